//! `seal.json`: hashes of the labels of a blind check, published before the data.

use serde::Deserialize;

/// Hashes of all labels.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct Seal {
    /// What is hashed, in words.
    #[serde(default)]
    pub hash: String,
    /// One entry a world.
    #[serde(default)]
    pub worlds: Vec<SealedWorld>,
}

/// The hash of one label.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct SealedWorld {
    /// The world.
    pub id: String,
    /// Hexadecimal.
    pub sha256: String,
}
