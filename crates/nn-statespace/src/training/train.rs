//! A whole training run in one call (paper, algorithm of the training process).

use super::config::TrainingConfig;
use super::epoch::EpochReport;
use super::report::{Provenance, Trained};
use super::run::{Advance, TrainingRun};
use crate::error::ModelError;
use crate::training_set::WindowSet;
use crate::widths::Widths;

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
