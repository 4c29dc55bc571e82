//! `seal.json` and `labels.json`: labels under seal.

use serde::{Deserialize, Serialize};

/// Hashes of all labels of a check: `seal.json`.
#[apply(strict!)]
#[derive(Eq)]
pub struct Seal {
    /// `seal/1`.
    pub schema: String,
    /// What is hashed, in words.
    pub hash: String,
    /// One entry a world.
    pub worlds: Vec<SealedWorld>,
}

/// The hash of one label.
#[apply(strict!)]
#[derive(Eq)]
pub struct SealedWorld {
    /// The world.
    pub id: String,
    /// Hexadecimal.
    pub sha256: String,
}

/// A label with what its hash was made of.
#[apply(strict!)]
#[derive(Eq)]
pub struct OpenedLabel {
    /// The world.
    pub id: String,
    /// Random text.
    pub salt: String,
    /// The label as JSON, byte by byte as it was hashed.
    pub label: String,
}

/// The labels of a check, opened when every answer is written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct OpenedLabels(pub Vec<OpenedLabel>);

impl OpenedLabel {
    /// A label to be sealed.
    #[must_use]
    pub fn new(id: impl Into<String>, salt: impl Into<String>, label: impl Into<String>) -> Self {
        Self { id: id.into(), salt: salt.into(), label: label.into() }
    }
}
