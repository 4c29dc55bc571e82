//! A whole training run in one call (paper, algorithm of the training process).

use serde::{Deserialize, Serialize};

use super::config::TrainingConfig;
use super::epoch::EpochReport;
use super::run::{Advance, TrainingRun};
use crate::error::ModelError;
use crate::population::PopulationModel;
use crate::training_set::WindowSet;
use crate::widths::Widths;

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

/// Trains a population model with the paper's wiring, as [`TrainingRun`] does, without a stop.
///
/// After each epoch `on_epoch` is told how it went.
///
/// # Errors
/// Those of [`TrainingRun::begin`] and [`TrainingRun::advance`].
pub fn train(
    config: &TrainingConfig,
    widths: &Widths,
    training: &WindowSet,
    validation: &WindowSet,
    provenance: Provenance,
    mut on_epoch: impl FnMut(&EpochReport),
) -> Result<Trained, ModelError> {
    let mut run = TrainingRun::begin(config, widths, training, validation)?;
    loop {
        match run.advance()? {
            Advance::Batch => {}
            Advance::Epoch(report) => on_epoch(&report),
            Advance::Finished => return run.finish(provenance),
        }
    }
}
