//! `manifest.json`: how an output folder was made.

/// Command, version, resolved configuration, seed and the hash of every input.
#[apply(strict!)]
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
#[apply(strict!)]
#[derive(Eq)]
pub struct FileHash {
    /// Path as given, with `/` between its parts.
    pub path: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}
