//! The training loop (paper, algorithm of the training process).

use candle_core::backprop::GradStore;
use candle_core::{DType, Device, Tensor, Var};
use candle_nn::{AdamW, Optimizer, ParamsAdamW};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::config::{GradientLimit, KeptWeights, TrainingConfig};
use super::epoch::EpochReport;
use super::initial_weights::initial_networks;
use super::loss::Loss;
use super::roll_out::RollOut;
use super::validation::validate;
use super::windows::{INPUTS, STATES, WindowSet};
use crate::card::ModelCard;
use crate::error::ModelError;
use crate::network::HiddenLayerNetwork;
use crate::per_compartment::PerCompartment;
use crate::population::{GlucoseClamp, PopulationModel};
use crate::widths::Widths;
use crate::wiring::Wiring;

/// Where the training data came from, for the model's card.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Provenance {
    /// In words.
    pub origin: String,
    /// SHA-256, in hexadecimal, of what [`WindowSet::write_canonical`] writes for the training
    /// windows; `None` if the caller does not keep one.
    pub training_data_sha256: Option<String>,
}

/// A trained model and how it came about.
#[derive(Debug, Clone)]
pub struct Trained {
    /// The model with the kept weights, Q1 running free (see [`GlucoseClamp`]).
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

/// Trains a population model with the paper's wiring.
///
/// Batches are drawn without replacement in an order that the seed fixes; each is simulated from
/// its windows' first states and updates the weights once by Adam. After each epoch the model is
/// judged on the validation windows and `on_epoch` is told. The same data, configuration and seed
/// give the same bytes, whatever the number of threads.
///
/// # Errors
/// [`ModelError::Training`] if the configuration does not fit the data or the loss stops being a
/// number; [`ModelError::Tensor`] from candle.
pub fn train(
    config: &TrainingConfig,
    widths: &Widths,
    training: &WindowSet,
    validation: &WindowSet,
    provenance: Provenance,
    mut on_epoch: impl FnMut(&EpochReport),
) -> Result<Trained, ModelError> {
    check(config, training, validation)?;
    let wiring = Wiring::paper();
    let start = initial_networks(&wiring, widths, config.initial_output_gain, config.seed);
    let model = RollOut::new(&wiring, &start, DType::F32)?;
    let loss = Loss::new(config.loss, training.scaler(), training.minima(), DType::F32)?;
    let mut optimiser = AdamW::new(
        model.variables(),
        ParamsAdamW { lr: 0.0, beta1: 0.9, beta2: 0.999, eps: 1e-8, weight_decay: 0.0 },
    )?;
    let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
    let mut order: Vec<usize> = (0..training.len()).collect();
    let mut epochs: Vec<EpochReport> = Vec::new();
    let mut kept: Option<(usize, f64, PerCompartment<HiddenLayerNetwork>)> = None;
    for (stage_index, stage) in config.stages.iter().enumerate() {
        for epoch_of_stage in 0..stage.epochs {
            let epoch = epochs.len();
            let learning_rate = stage.learning_rate.at(epoch_of_stage);
            optimiser.set_learning_rate(learning_rate);
            order.shuffle(&mut rng);
            let mut weighted = 0.0;
            for (number, batch) in order.chunks(config.batch).enumerate() {
                let tensors = batch_tensors(training, batch, stage.steps, DType::F32)?;
                let simulated = model.simulate(&tensors.initial, &tensors.inputs)?;
                let value = loss.total(&simulated, &tensors.truth)?;
                let scalar = f64::from(value.to_scalar::<f32>()?);
                if !scalar.is_finite() {
                    let problem = format!(
                        "the loss of epoch {epoch}, batch {number} is {scalar}; lower the \
                         learning rate or the initial output gain"
                    );
                    return Err(ModelError::Training { problem });
                }
                weighted += scalar * batch.len() as f64;
                let mut gradients = value.backward()?;
                limit(&mut gradients, &model.variables(), config.gradient_limit)?;
                optimiser.step(&gradients)?;
            }
            let report = EpochReport {
                epoch,
                stage: stage_index,
                steps: stage.steps,
                learning_rate,
                training_loss: weighted / training.len() as f64,
                validation: validate(&model, validation)?,
            };
            on_epoch(&report);
            epochs.push(report);
            let error = report.validation.balanced();
            let keep = match (&kept, config.keep) {
                (None, _) | (_, KeptWeights::LastEpoch) => true,
                // A NaN must not win, nor stay.
                (Some((_, best, _)), KeptWeights::LowestValidationError) => {
                    error < *best || best.is_nan()
                }
            };
            if keep {
                kept = Some((epoch, error, model.networks()?));
            }
        }
    }
    let (kept_epoch, _, networks) = kept.expect("a configuration without epochs is refused");
    let report = TrainingReport {
        config: config.clone(),
        training_windows: training.len(),
        validation_windows: validation.len(),
        epochs,
        kept_epoch,
    };
    let card = ModelCard {
        origin: provenance.origin,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        training_data_sha256: provenance.training_data_sha256,
        training: serde_json::to_value(config).ok(),
    };
    let scaler = *training.scaler();
    let model = PopulationModel::new(wiring, networks, scaler, GlucoseClamp::Off, card)?;
    Ok(Trained { model, report })
}

fn check(
    config: &TrainingConfig,
    training: &WindowSet,
    validation: &WindowSet,
) -> Result<(), ModelError> {
    let problem = |problem: String| Err(ModelError::Training { problem });
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

/// A batch of windows as tensors.
pub(super) struct BatchTensors {
    /// Shape (batch, 10).
    pub(super) initial: Tensor,
    /// Shape (steps, batch, 2).
    pub(super) inputs: Tensor,
    /// Shape (steps, batch, 10), without the start.
    pub(super) truth: Tensor,
}

/// The first `steps` steps of the named windows.
pub(super) fn batch_tensors(
    windows: &WindowSet,
    batch: &[usize],
    steps: usize,
    dtype: DType,
) -> Result<BatchTensors, ModelError> {
    let mut initial = Vec::with_capacity(batch.len() * STATES);
    let mut inputs = Vec::with_capacity(steps * batch.len() * INPUTS);
    let mut truth = Vec::with_capacity(steps * batch.len() * STATES);
    for window in batch {
        initial.extend_from_slice(&windows.states(*window)[..STATES]);
    }
    for step in 0..steps {
        for window in batch {
            inputs.extend_from_slice(&windows.inputs(*window)[step * INPUTS..][..INPUTS]);
            truth.extend_from_slice(&windows.states(*window)[(step + 1) * STATES..][..STATES]);
        }
    }
    let size = batch.len();
    Ok(BatchTensors {
        initial: Tensor::from_vec(initial, (size, STATES), &Device::Cpu)?.to_dtype(dtype)?,
        inputs: Tensor::from_vec(inputs, (steps, size, INPUTS), &Device::Cpu)?.to_dtype(dtype)?,
        truth: Tensor::from_vec(truth, (steps, size, STATES), &Device::Cpu)?.to_dtype(dtype)?,
    })
}

/// Scales the gradient down to the limit where it is longer.
fn limit(
    gradients: &mut GradStore,
    variables: &[Var],
    limit: GradientLimit,
) -> Result<(), ModelError> {
    let GradientLimit::Norm(longest) = limit else { return Ok(()) };
    let mut squares = 0.0;
    for gradient in variables.iter().filter_map(|variable| gradients.get(variable)) {
        squares += f64::from(gradient.sqr()?.sum_all()?.to_scalar::<f32>()?);
    }
    let norm = squares.sqrt();
    if norm > longest {
        for variable in variables {
            if let Some(gradient) = gradients.remove(variable) {
                gradients.insert(variable, (gradient * (longest / norm))?);
            }
        }
    }
    Ok(())
}
