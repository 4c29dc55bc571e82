//! The training loop (paper, algorithm of the training process), one update at a time, so that it
//! can be stopped and taken up again, or in one call.

use std::io::Write;

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::adam::Adam;
use super::checkpoint::{Checkpoint, Header, Kept};
use super::config::{GradientLimit, KeptWeights, Stage, TrainingConfig};
use super::initial_weights::initial_networks;
use super::loss_terms::LossTerms;
use super::report::{EpochReport, Provenance, Trained, TrainingReport};
use super::slope_constraints::SlopeKeeper;
use super::validation::validate;
use crate::error::ModelError;
use crate::kernel::{FusedRollOut, Sequence};
use crate::population::{GlucoseClamp, ModelCard, PopulationModel, scaled_glucose_range};
use crate::training_set::WindowSet;
use crate::widths::Widths;
use crate::wiring::Wiring;

/// Streams of the seed below this one are those of the initial weights; the order of an epoch's
/// batches has the stream that follows it by the epoch's number.
const FIRST_ORDER: u64 = 1 << 32;

/// By how much an epoch's error counts for more, where the best is kept, if slopes do not have their signs although they
/// are to be kept: a repair costs some of that.
const WRONG_SLOPES: f64 = 1.25;

/// A training run between two updates.
///
/// Batches are drawn without replacement in an order that seed and epoch fix; each is simulated from
/// its windows' first states and updates the weights once by Adam. After each epoch the model is
/// judged on the validation windows. The same data, configuration and seed give the same bytes,
/// whatever the number of threads and however often the run was stopped and resumed.
#[derive(Debug)]
pub struct TrainingRun<'a> {
    state: Checkpoint,
    training: &'a WindowSet,
    validation: &'a WindowSet,
    roll_out: FusedRollOut<f32>,
    /// Windows of the present epoch in their order; empty before it is drawn.
    order: Vec<usize>,
    gradient: Vec<f32>,
    keeper: SlopeKeeper,
}

/// What [`TrainingRun::advance`] did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Advance {
    /// One update.
    Batch,
    /// The last update of an epoch, and the validation.
    Epoch(EpochReport),
    /// Nothing: all epochs are done.
    Finished,
}

impl<'a> TrainingRun<'a> {
    /// A run at its start, with the paper's wiring.
    ///
    /// # Errors
    /// [`ModelError::Training`] if the configuration does not fit the data.
    pub fn begin(
        config: &TrainingConfig,
        widths: &Widths,
        training: &'a WindowSet,
        validation: &'a WindowSet,
    ) -> Result<Self, ModelError> {
        check(config, training, validation)?;
        let wiring = Wiring::paper();
        let mut roll_out = FusedRollOut::new(&wiring, widths);
        if config.clamp == GlucoseClamp::Reproduction {
            roll_out = roll_out.with_glucose_range(scaled_glucose_range(training.scaler()));
        }
        let networks = initial_networks(&wiring, widths, config.initial_output_gain, config.seed);
        let mut parameters: Vec<f32> = roll_out.layout().flatten(&networks)?;
        let keeper = SlopeKeeper::new(config.slopes, roll_out.layout(), training, config.seed);
        keeper.orient(&mut parameters);
        let each = physiology::Compartment::ALL.map(|compartment| widths.of(compartment));
        let state = Checkpoint {
            header: Header::new(config, each.into(), fingerprint(training, validation)),
            weighted_loss: 0.0,
            adam: Adam::new(parameters.len()),
            epochs: Vec::new(),
            kept: None,
            parameters,
        };
        let gradient = vec![0.0; state.parameters.len()];
        Ok(Self { state, training, validation, roll_out, order: Vec::new(), gradient, keeper })
    }

    /// The run that [`Self::checkpoint`] wrote down, to go on from there.
    ///
    /// # Errors
    /// [`ModelError::Training`] if the bytes are damaged or those of a run with another
    /// configuration, other widths or other data, and as [`Self::begin`].
    pub fn resume(
        checkpoint: &[u8],
        config: &TrainingConfig,
        widths: &Widths,
        training: &'a WindowSet,
        validation: &'a WindowSet,
    ) -> Result<Self, ModelError> {
        let begun = Self::begin(config, widths, training, validation)?;
        let state = Checkpoint::from_bytes(checkpoint)?;
        let (now, then) = (&begun.state.header, &state.header);
        // After an epoch's last batch the count begins at 0 again.
        let windows_done = then.batches.checked_mul(then.config.batch);
        let other = if now.config != then.config {
            "another configuration"
        } else if now.widths != then.widths || begun.gradient.len() != state.parameters.len() {
            "other widths"
        } else if now.data != then.data {
            "other data"
        } else if windows_done.is_none_or(|done| done >= training.len()) {
            "more batches than an epoch has"
        } else {
            return Ok(Self { state, ..begun });
        };
        Err(ModelError::Training(format!("the checkpoint is of a run with {other}")))
    }

    /// The run as bytes. It goes on from them exactly as it would have without a stop.
    #[must_use]
    pub fn checkpoint(&self) -> Vec<u8> {
        self.state.to_bytes()
    }

    /// Updates done so far.
    #[must_use]
    pub fn updates(&self) -> usize {
        self.state.adam.updates as usize
    }

    /// Reports of the epochs done so far.
    #[must_use]
    pub fn epochs(&self) -> &[EpochReport] {
        &self.state.epochs
    }

    /// Does the next update, and the validation if it ends an epoch.
    ///
    /// # Errors
    /// [`ModelError::Training`] if the loss or its gradient stops being a number.
    pub fn advance(&mut self) -> Result<Advance, ModelError> {
        let Some((stage_index, stage)) = self.stage() else { return Ok(Advance::Finished) };
        let in_stage = self.in_stage(stage_index).count();
        let learning_rate = stage.learning_rate.at(in_stage);
        if self.order.is_empty() {
            let (seed, epoch) = (self.state.header.config.seed, self.state.epochs.len());
            self.order = order_of(self.training.len(), seed, epoch);
        }
        let state = &mut self.state;
        let first = state.header.batches * state.header.config.batch;
        let last = self.order.len().min(first + state.header.config.batch);
        let batch: Vec<Sequence<'_, f32>> = self.order[first..last]
            .iter()
            .map(|window| self.training.sequence(*window, stage.steps))
            .collect();
        let (config, samples) = (&state.header.config, batch.len() * stage.steps);
        let (scaler, minima) = (self.training.scaler(), self.training.minima());
        let terms = LossTerms::new(&config.loss, scaler, minima, samples);
        let gradient = &mut self.gradient;
        let loss = self.roll_out.gradient(&state.parameters, &batch, &terms, gradient)?;
        let norm = gradient.iter().map(|slope| f64::from(*slope).powi(2)).sum::<f64>().sqrt();
        if !loss.is_finite() || !norm.is_finite() {
            let problem = format!(
                "the loss of epoch {}, batch {} is {loss}, its gradient {norm}; lower the learning \
                 rate or the initial output gain",
                state.epochs.len(),
                state.header.batches,
            );
            return Err(ModelError::Training(problem));
        }
        limit(gradient, norm, config.gradient_limit);
        self.keeper.add_penalty(&state.parameters, state.adam.updates, gradient);
        state.weighted_loss += loss * batch.len() as f64;
        state.adam.update(&mut state.parameters, gradient, learning_rate);
        self.keeper.project(&mut state.parameters);
        state.header.updates = state.adam.updates;
        state.header.batches += 1;
        if last < self.order.len() {
            return Ok(Advance::Batch);
        }
        let report = EpochReport {
            epoch: state.epochs.len(),
            stage: stage_index,
            steps: stage.steps,
            learning_rate,
            training_loss: state.weighted_loss / self.order.len() as f64,
            validation: validate(&mut self.roll_out, &state.parameters, self.validation)?,
        };
        self.end_epoch(report);
        Ok(Advance::Epoch(report))
    }

    /// The model with the kept weights, and the record of the run.
    ///
    /// # Errors
    /// [`ModelError::Training`] if no epoch is done.
    pub fn finish(self, provenance: Provenance) -> Result<Trained, ModelError> {
        let Checkpoint { header, epochs, kept, .. } = self.state;
        let kept = kept.ok_or_else(|| ModelError::Training("no epoch is done".to_owned()))?;
        let networks = self.roll_out.layout().networks(&kept.parameters)?;
        let card = ModelCard {
            origin: provenance.origin,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            training_data_sha256: provenance.training_data_sha256,
            training: serde_json::to_value(&header.config).ok(),
        };
        let (scaler, clamp) = (*self.training.scaler(), header.config.clamp);
        let model = PopulationModel::new(Wiring::paper(), networks, scaler, clamp, card)?;
        let report = TrainingReport {
            config: header.config,
            training_windows: self.training.len(),
            validation_windows: self.validation.len(),
            epochs,
            kept_epoch: kept.epoch,
        };
        Ok(Trained { model, report })
    }

    /// The stage that the next update belongs to; none if all are done.
    fn stage(&self) -> Option<(usize, Stage)> {
        let config = &self.state.header.config;
        config.stages.iter().copied().enumerate().find(|(index, stage)| {
            let errors: Vec<f64> =
                self.in_stage(*index).map(|report| report.validation.balanced()).collect();
            errors.len() < stage.epochs && !config.stop.ends(&errors)
        })
    }

    /// Reports of a stage.
    fn in_stage(&self, stage: usize) -> impl Iterator<Item = &EpochReport> {
        self.state.epochs.iter().filter(move |report| report.stage == stage)
    }

    /// Writes an epoch down and keeps its weights if they are to be kept.
    fn end_epoch(&mut self, report: EpochReport) {
        let state = &mut self.state;
        let error = report.validation.balanced();
        let keep = match (&state.kept, state.header.config.keep) {
            (None, _) | (_, KeptWeights::LastEpoch) => true,
            (Some(kept), KeptWeights::LowestValidationError) => {
                let counted = |error: f64, parameters: &[f32]| {
                    if self.keeper.holds(parameters) { error } else { WRONG_SLOPES * error }
                };
                // A NaN must not win, nor stay.
                counted(error, &state.parameters) < counted(kept.error, &kept.parameters)
                    || kept.error.is_nan()
            }
        };
        if keep {
            let parameters = state.parameters.clone();
            state.kept = Some(Kept { epoch: report.epoch, error, parameters });
            state.header.kept_epoch = Some(report.epoch);
        }
        state.epochs.push(report);
        state.header.batches = 0;
        state.weighted_loss = 0.0;
        self.order.clear();
    }
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

fn check(
    config: &TrainingConfig,
    training: &WindowSet,
    validation: &WindowSet,
) -> Result<(), ModelError> {
    let problem = |problem: String| Err(ModelError::Training(problem));
    if training.scaler() != validation.scaler() {
        return problem("training and validation windows are scaled differently".to_owned());
    }
    if config.batch == 0 || config.stages.iter().all(|stage| stage.epochs == 0) {
        return problem("no batches or no epochs".to_owned());
    }
    match config.stages.iter().find(|s| s.steps == 0 || s.steps > training.length()) {
        Some(stage) => {
            problem(format!("a stage of {} steps on windows of {}", stage.steps, training.length()))
        }
        None => Ok(()),
    }
}

/// The order of the windows in an epoch.
fn order_of(windows: usize, seed: u64, epoch: usize) -> Vec<usize> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(FIRST_ORDER + epoch as u64);
    let mut order: Vec<usize> = (0..windows).collect();
    order.shuffle(&mut rng);
    order
}

/// Scales the gradient, whose length is `norm`, down to the limit where it is longer.
fn limit(gradient: &mut [f32], norm: f64, limit: GradientLimit) {
    let GradientLimit::Norm(longest) = limit else { return };
    if norm > longest {
        let factor = (longest / norm) as f32;
        for slope in gradient {
            *slope *= factor;
        }
    }
}

/// A number that other data would hardly have, in hexadecimal (FNV-1a, 64 bits).
fn fingerprint(training: &WindowSet, validation: &WindowSet) -> String {
    let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
    for windows in [training, validation] {
        windows.write_canonical(&mut hash).expect("a number takes every byte");
    }
    format!("{:016x}", hash.0)
}

/// FNV-1a as something to write into.
struct Fnv(u64);

impl Write for Fnv {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_epoch_and_every_seed_has_an_order_of_its_own() {
        let orders = [order_of(50, 1, 0), order_of(50, 1, 1), order_of(50, 2, 0)];
        for (index, order) in orders.iter().enumerate() {
            assert!(orders[..index].iter().all(|other| other != order));
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..50).collect::<Vec<_>>());
        }
        assert_eq!(order_of(50, 1, 1), orders[1]);
    }

    #[test]
    fn a_long_gradient_is_shortened_to_the_limit_and_keeps_its_direction() {
        for (longest, expected) in [(5.0, [3.0, 4.0]), (1.0, [0.6, 0.8]), (10.0, [3.0, 4.0])] {
            let mut gradient = [3.0, 4.0];
            limit(&mut gradient, 5.0, GradientLimit::Norm(longest));
            assert_eq!(gradient, expected, "{longest}");
        }
        let mut gradient = [3.0, 4.0];
        limit(&mut gradient, 5.0, GradientLimit::Off);
        assert_eq!(gradient, [3.0, 4.0]);
    }
}
