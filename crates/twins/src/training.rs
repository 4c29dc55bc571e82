//! Training of one person's residual network.

use candle_core::{Device, Tensor};
use candle_nn::{AdamW, Optimizer, ParamsAdamW};
use nn_statespace::PopulationModel;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::error::TwinError;
use crate::gradient::{Objective, Tape};
use crate::graph::ResidualVariables;
use crate::loss::TwinLoss;
use crate::prepared::PreparedWindow;
use crate::residual::{ResidualNetwork, SHAPES};

/// How a residual network is trained.
///
/// The optimiser is Adam with decoupled weight decay (candle's AdamW) at a constant rate.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TrainingPlan {
    /// The loss.
    pub loss: TwinLoss,
    /// Learning rate, constant.
    pub learning_rate: f64,
    /// Weight decay.
    pub weight_decay: f64,
    /// Windows a batch; the last of an epoch may be smaller.
    pub batch: usize,
    /// Passes over the windows.
    pub epochs: usize,
    /// Which epoch's weights are kept.
    pub keep: KeptEpoch,
}

/// Which epoch's weights are kept. Test days are never looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum KeptEpoch {
    /// The last.
    Last,
    /// The one with the lowest loss on the held-out windows; on the training windows if none were
    /// held out.
    Best,
}

impl TrainingPlan {
    /// The paper: penalty 8.5 and 6, alpha 10, rate 1e-4, 150 epochs; batch 32 and weight decay
    /// 1e-5, on which the paper is silent, from the authors' published code.
    #[must_use]
    pub const fn paper() -> Self {
        Self {
            loss: TwinLoss::PAPER,
            learning_rate: 1e-4,
            weight_decay: 1e-5,
            batch: 32,
            epochs: 150,
            keep: KeptEpoch::Last,
        }
    }

    /// As [`paper`](Self::paper) with the penalty of the authors' published code, 6 and 6.
    #[must_use]
    pub const fn authors_code() -> Self {
        Self { loss: TwinLoss::AUTHORS_CODE, ..Self::paper() }
    }

    /// A short training: three times the paper's rate and 16 epochs, for hourly windows
    /// ([`Protocol::quick`](crate::Protocol::quick)).
    ///
    /// Both were set on made people, where longer training kept lowering the training loss and no
    /// longer the error on other days.
    #[must_use]
    pub const fn quick() -> Self {
        Self { learning_rate: 3e-4, epochs: 16, ..Self::paper() }
    }

    fn check(&self) -> Result<(), TwinError> {
        let cases = [
            ("learning_rate", self.learning_rate, self.learning_rate > 0.0, "positive"),
            ("weight_decay", self.weight_decay, self.weight_decay >= 0.0, "at least 0"),
            ("batch", self.batch as f64, self.batch > 0, "at least 1"),
            ("epochs", self.epochs as f64, self.epochs > 0, "at least 1"),
            ("penalty.low", self.loss.penalty.low, self.loss.penalty.low > 0.0, "positive"),
            ("penalty.high", self.loss.penalty.high, self.loss.penalty.high > 0.0, "positive"),
            ("consistency", self.loss.consistency, self.loss.consistency >= 0.0, "at least 0"),
        ];
        for (setting, value, holds, requirement) in cases {
            if !holds || !value.is_finite() {
                return Err(TwinError::Setting { setting, value, requirement });
            }
        }
        Ok(())
    }
}

/// Losses of one epoch, per window and step, in scaled units of Q1.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Epoch {
    /// Mean loss over the training windows while the epoch ran.
    pub training: f64,
    /// Mean loss over the held-out windows after the epoch; `None` if none were held out.
    pub held_out: Option<f64>,
}

/// A trained network and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// The network of the kept epoch.
    pub network: ResidualNetwork,
    /// Mean loss over the training windows before the first epoch.
    pub loss_before: f64,
    /// Mean loss over the held-out windows before the first epoch.
    pub held_out_before: Option<f64>,
    /// Losses of each epoch.
    pub epochs: Vec<Epoch>,
    /// Number of epochs behind the kept network; 0 if none improved on the start.
    pub kept: usize,
    /// Mean loss of the kept network over the training windows.
    pub loss_after: f64,
}

/// Trains from `start`: [`ResidualNetwork::untrained`], or a network that new days continue.
///
/// Windows are shuffled in each epoch by a generator seeded with `seed`. The work is sequential,
/// so that the result does not depend on the number of threads; people train in parallel.
///
/// # Errors
/// [`TwinError::Setting`], [`TwinError::NoWindows`], [`TwinError::UnequalWindows`],
/// [`TwinError::Diverged`] and [`TwinError::Candle`].
pub fn train(
    population: &PopulationModel,
    start: ResidualNetwork,
    windows: &[PreparedWindow],
    held_out: &[PreparedWindow],
    plan: &TrainingPlan,
    seed: u64,
) -> Result<Trained, TwinError> {
    plan.check()?;
    let first = windows.first().ok_or(TwinError::NoWindows)?.steps();
    if let Some(other) = windows.iter().find(|w| w.steps() != first) {
        return Err(TwinError::UnequalWindows { first, other: other.steps() });
    }
    let objective = Objective { population, loss: plan.loss.scaled_by(population) };
    let variables = ResidualVariables::new(&start)?;
    let mut optimiser = AdamW::new(
        variables.variables().to_vec(),
        ParamsAdamW {
            lr: plan.learning_rate,
            weight_decay: plan.weight_decay,
            ..ParamsAdamW::default()
        },
    )?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut tape = Tape::default();
    let mut network = start;
    let mut order: Vec<usize> = (0..windows.len()).collect();

    let loss_before = mean_loss(&objective, &network, windows, &mut tape);
    let held_out_before =
        (!held_out.is_empty()).then(|| mean_loss(&objective, &network, held_out, &mut tape));
    finite(loss_before, 0)?;
    let mut best = (held_out_before.unwrap_or(loss_before), 0, network.clone());
    let mut epochs = Vec::with_capacity(plan.epochs);
    for number in 0..plan.epochs {
        shuffle(&mut order, &mut rng);
        let mut sum = 0.0;
        for batch in order.chunks(plan.batch) {
            let mut gradient = ResidualNetwork::zeros();
            for index in batch {
                sum += objective.loss_and_gradient(
                    &network,
                    &windows[*index],
                    &mut tape,
                    &mut gradient,
                );
            }
            descend(&mut optimiser, &variables, &gradient, batch.len())?;
            network = variables.network()?;
        }
        let training = finite(sum / windows.len() as f64, number)?;
        let held_out_loss =
            (!held_out.is_empty()).then(|| mean_loss(&objective, &network, held_out, &mut tape));
        epochs.push(Epoch { training, held_out: held_out_loss });
        if plan.keep == KeptEpoch::Best {
            let judged = match held_out_loss {
                Some(loss) => loss,
                None => mean_loss(&objective, &network, windows, &mut tape),
            };
            if finite(judged, number)? < best.0 {
                best = (judged, number + 1, network.clone());
            }
        }
    }
    let (kept, network) = match plan.keep {
        KeptEpoch::Last => (plan.epochs, network),
        KeptEpoch::Best => (best.1, best.2),
    };
    let loss_after = finite(mean_loss(&objective, &network, windows, &mut tape), plan.epochs - 1)?;
    Ok(Trained { network, loss_before, held_out_before, epochs, kept, loss_after })
}

/// Mean loss of a network over windows, per window and step, in scaled units of Q1.
///
/// # Errors
/// [`TwinError::NoWindows`].
pub fn window_loss(
    population: &PopulationModel,
    network: &ResidualNetwork,
    windows: &[PreparedWindow],
    loss: TwinLoss,
) -> Result<f64, TwinError> {
    if windows.is_empty() {
        return Err(TwinError::NoWindows);
    }
    let objective = Objective { population, loss: loss.scaled_by(population) };
    Ok(mean_loss(&objective, network, windows, &mut Tape::default()))
}

/// Mean loss of a batch and its gradient by the roll-out by hand. The gradient has the shape of a
/// network.
///
/// # Errors
/// [`TwinError::NoWindows`].
pub fn batch_gradient(
    population: &PopulationModel,
    network: &ResidualNetwork,
    windows: &[&PreparedWindow],
    loss: TwinLoss,
) -> Result<(f64, ResidualNetwork), TwinError> {
    if windows.is_empty() {
        return Err(TwinError::NoWindows);
    }
    let objective = Objective { population, loss: loss.scaled_by(population) };
    let mut gradient = ResidualNetwork::zeros();
    let mut tape = Tape::default();
    let mut sum = 0.0;
    for window in windows {
        sum += objective.loss_and_gradient(network, window, &mut tape, &mut gradient);
    }
    let share = 1.0 / windows.len() as f64;
    for layer in gradient.layers_mut() {
        for value in layer.weight.iter_mut().chain(&mut layer.bias) {
            *value *= share;
        }
    }
    Ok((sum * share, gradient))
}

fn mean_loss(
    objective: &Objective<'_>,
    network: &ResidualNetwork,
    windows: &[PreparedWindow],
    tape: &mut Tape,
) -> f64 {
    let sum: f64 = windows.iter().map(|w| objective.loss(network, w, tape)).sum();
    sum / windows.len() as f64
}

fn finite(loss: f64, epoch: usize) -> Result<f64, TwinError> {
    if loss.is_finite() { Ok(loss) } else { Err(TwinError::Diverged { epoch }) }
}

/// One step of candle's optimiser along a gradient that was computed outside its graph: the sum
/// of variable times gradient has exactly that gradient.
fn descend(
    optimiser: &mut AdamW,
    variables: &ResidualVariables,
    gradient: &ResidualNetwork,
    windows: usize,
) -> Result<(), TwinError> {
    let mut surrogate = Tensor::new(0.0, &Device::Cpu)?;
    let share = 1.0 / windows as f64;
    let pairs = variables.variables().chunks_exact(2);
    for ((layer, pair), shape) in gradient.layers().iter().zip(pairs).zip(SHAPES) {
        let weight = Tensor::from_slice(&layer.weight, shape, &Device::Cpu)?;
        let bias = Tensor::from_slice(&layer.bias, (1, shape.1), &Device::Cpu)?;
        for (variable, slope) in pair.iter().zip([weight, bias]) {
            let term = (variable.as_tensor() * (slope * share)?)?.sum_all()?;
            surrogate = (surrogate + term)?;
        }
    }
    Ok(optimiser.backward_step(&surrogate)?)
}

/// Fisher and Yates.
fn shuffle(order: &mut [usize], rng: &mut ChaCha8Rng) {
    for i in (1..order.len()).rev() {
        order.swap(i, rng.random_range(0..=i));
    }
}
