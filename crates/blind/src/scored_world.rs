//! What is scored: a label and an answer.

use contract::blind_check::{Answer, Label};

/// A world with its label and its answer.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoredWorld {
    /// The truth.
    pub label: Label,
    /// The answer.
    pub answer: Answer,
}
