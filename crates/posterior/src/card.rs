//! What a posterior saw.

use serde::{Deserialize, Serialize};

/// What a posterior was trained on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Card {
    /// The command that trained it.
    pub source: String,
    /// Hands whose worlds it saw, with the number of worlds.
    pub hands: Vec<(String, usize)>,
    /// Share of the worlds in which nothing is missing: its prior.
    pub nothing: f64,
    /// Members of the ensemble.
    pub members: usize,
}
