//! What is scored: a label and an answer.

use contract::blind_check::{Answer, Label};

/// A world whose label is known and whose answer is in.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoredWorld {
    /// The truth.
    pub label: Label,
    /// The answer.
    pub answer: Answer,
}
