//! `manifest.json`: how a stage was run.

use serde::Deserialize;

/// Command, version, resolved configuration, seed and input hashes of one stage.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Manifest {
    /// The stage or command.
    #[serde(default)]
    pub stage: Option<String>,
    /// The command line as typed.
    #[serde(alias = "command_line")]
    pub command: String,
    /// Version of the program.
    pub version: String,
    /// The resolved configuration, whatever its keys.
    #[serde(default)]
    pub config: serde_json::Value,
    /// The seed, where one was used.
    #[serde(default)]
    pub seed: Option<u64>,
    /// Every file that was read.
    #[serde(default)]
    pub inputs: Vec<ManifestInput>,
}

/// One file that was read.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct ManifestInput {
    /// Its path as given.
    pub path: String,
    /// SHA-256 of its bytes, hexadecimal.
    #[serde(alias = "hash")]
    pub sha256: String,
}
