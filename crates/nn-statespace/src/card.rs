//! What a weight file says about where it came from.

use serde::{Deserialize, Serialize};

/// Provenance of a model, kept in its weight file.
///
/// Everything that follows from the weights themselves (widths, wiring, state order) is written
/// from the model and is not repeated here.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModelCard {
    /// Where the weights came from, in words: "trained on ...", "imported from ...".
    pub origin: String,
    /// Version of the software that made them.
    pub version: String,
    /// SHA-256 of the training data in hexadecimal; `None` where the data are not at hand, as for
    /// published weights.
    pub training_data_sha256: Option<String>,
    /// The resolved training configuration as JSON; `None` where it is not known.
    pub training: Option<serde_json::Value>,
}
