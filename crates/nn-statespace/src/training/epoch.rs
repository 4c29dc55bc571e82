//! What an epoch of training came to.

use serde::{Deserialize, Serialize};

use super::validation::GroupErrors;

/// One epoch's point on the training curves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EpochReport {
    /// Counted from 0 over the whole run.
    pub epoch: usize,
    /// The stage it belongs to, counted from 0.
    pub stage: usize,
    /// Steps rolled out.
    pub steps: usize,
    /// Learning rate of Adam.
    pub learning_rate: f64,
    /// Mean over batches, weighted by their windows, of the loss before each update; scaled units.
    pub training_loss: f64,
    /// Glucose error on the validation windows, at full length.
    pub validation: GroupErrors,
}
