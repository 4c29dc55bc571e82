//! What an epoch of training came to, and what a run returns.

use serde::{Deserialize, Serialize};

use super::config::TrainingConfig;
use super::validation::GroupErrors;
use crate::population::PopulationModel;

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

/// Where the training data came from, for the model's card.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Provenance {
    /// In words.
    pub origin: String,
    /// SHA-256, in hexadecimal, that names the data the training windows were cut from; `None` if
    /// the caller does not keep one.
    pub training_data_sha256: Option<String>,
}

/// A trained model and how it came about.
#[derive(Debug, Clone)]
pub struct Trained {
    /// The model with the kept weights, and with the clamp of Q1 that it was trained with.
    pub model: PopulationModel,
    /// Configuration and curves.
    pub report: TrainingReport,
}

/// The record of a training run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainingReport {
    /// The resolved configuration.
    pub config: TrainingConfig,
    /// Windows trained on.
    pub training_windows: usize,
    /// Windows validated on.
    pub validation_windows: usize,
    /// One point an epoch.
    pub epochs: Vec<EpochReport>,
    /// The epoch whose weights were kept.
    pub kept_epoch: usize,
}
