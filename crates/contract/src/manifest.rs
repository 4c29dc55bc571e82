//! `manifest.json`: how an output folder was made.

use serde::{Deserialize, Serialize};

/// Command, version, resolved configuration, seed and the hash of every input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Always `manifest/1`.
    pub schema: String,
    /// The stage or command that wrote the folder.
    pub stage: String,
    /// The command line as typed.
    pub command: String,
    /// Version of this program.
    pub version: String,
    /// The resolved configuration.
    pub config: serde_json::Value,
    /// The seed, where one was used.
    pub seed: Option<u64>,
    /// Every file that was read.
    pub inputs: Vec<FileHash>,
    /// Every file that was written beside the manifest, by its path within the folder.
    pub outputs: Vec<FileHash>,
}

/// One file with its bytes' hash.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FileHash {
    /// Path as given, with `/` between its parts.
    pub path: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}
