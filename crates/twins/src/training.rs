//! Training of one person's residual network.

use nn_statespace::training::Adam;
use nn_statespace::{PopulationModel, Signal};
use physiology::{Compartment, MgPerDl};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::error::TwinError;
use crate::loss::TwinLoss;
use crate::prepared::PreparedWindow;
use crate::residual::{PARAMETERS, ResidualNetwork};
use crate::roll_out::{Precision, TwinRollOut, network_of, parameters_of};
use crate::signs::{Keeper, Signs};

/// How a residual network is trained.
///
/// The optimiser is Adam with decoupled weight decay at a constant rate; weights and roll-outs are in
/// single precision, losses are summed in double precision.
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
    /// Whether the network keeps physiology's signs.
    pub signs: Signs,
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
            signs: Signs::Free,
        }
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
/// [`TwinError::Setting`], [`TwinError::NoWindows`], [`TwinError::UnequalWindows`] and
/// [`TwinError::Diverged`].
pub fn train(
    population: &PopulationModel,
    start: ResidualNetwork,
    windows: &[PreparedWindow],
    held_out: &[PreparedWindow],
    plan: &TrainingPlan,
    seed: u64,
) -> Result<Trained, TwinError> {
    plan.check()?;
    let windows = same_length(windows.iter().chain(held_out))?;
    let (windows, held_out) = windows.split_at(windows.len() - held_out.len());
    if windows.is_empty() {
        return Err(TwinError::NoWindows);
    }
    let mut roll_out = TwinRollOut::<f32>::new(population, plan.loss.scaled_by(population))?;
    let mut optimiser = Adam::new(PARAMETERS).with_weight_decay(plan.weight_decay);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut parameters: Vec<f32> = parameters_of(&start);
    let keeper = Keeper::new(plan.signs);
    if let Some(keeper) = keeper.as_ref().filter(|_| !start.keeps_signs()) {
        keeper.begin(&mut parameters);
    }
    let mut gradient = vec![0.0; PARAMETERS];
    let mut order: Vec<usize> = (0..windows.len()).collect();
    let mut batch = Vec::with_capacity(plan.batch);

    let loss_before = mean_loss(&mut roll_out, &parameters, windows);
    let judge_held_out = |roll_out: &mut TwinRollOut<f32>, parameters: &[f32]| {
        (!held_out.is_empty()).then(|| mean_loss(roll_out, parameters, held_out))
    };
    let held_out_before = judge_held_out(&mut roll_out, &parameters);
    finite(loss_before, 0)?;
    let mut best = (held_out_before.unwrap_or(loss_before), 0, parameters.clone());
    let mut epochs = Vec::with_capacity(plan.epochs);
    for number in 0..plan.epochs {
        shuffle(&mut order, &mut rng);
        let mut sum = 0.0;
        for chosen in order.chunks(plan.batch) {
            batch.clear();
            batch.extend(chosen.iter().map(|index| windows[*index]));
            gradient.fill(0.0);
            sum += roll_out.loss(&parameters, &batch, Some(&mut gradient));
            let share = 1.0 / batch.len() as f32;
            gradient.iter_mut().for_each(|slope| *slope *= share);
            optimiser.update(&mut parameters, &gradient, plan.learning_rate);
            if let Some(keeper) = &keeper {
                keeper.keep(&mut parameters);
            }
        }
        let training = finite(sum / windows.len() as f64, number)?;
        let held_out_loss = judge_held_out(&mut roll_out, &parameters);
        epochs.push(Epoch { training, held_out: held_out_loss });
        if plan.keep == KeptEpoch::Best {
            let judged =
                held_out_loss.unwrap_or_else(|| mean_loss(&mut roll_out, &parameters, windows));
            if finite(judged, number)? < best.0 {
                best = (judged, number + 1, parameters.clone());
            }
        }
    }
    let (kept, parameters) = match plan.keep {
        KeptEpoch::Last => (plan.epochs, parameters),
        KeptEpoch::Best => (best.1, best.2),
    };
    let loss_after = finite(mean_loss(&mut roll_out, &parameters, windows), plan.epochs - 1)?;
    let network = network_of(&parameters);
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
    let windows = same_length(windows.iter())?;
    let mut roll_out = TwinRollOut::<f64>::new(population, loss.scaled_by(population))?;
    Ok(mean_loss(&mut roll_out, &parameters_of(network), &windows))
}

/// Glucose of free runs of a twin's networks through windows, mg/dL, the start first, in f64.
///
/// # Errors
/// [`TwinError::NoWindows`] and [`TwinError::UnequalWindows`].
pub fn window_courses(
    population: &PopulationModel,
    network: &ResidualNetwork,
    windows: &[PreparedWindow],
) -> Result<Vec<Vec<MgPerDl>>, TwinError> {
    let windows = same_length(windows.iter())?;
    let loss = TwinLoss::PAPER.scaled_by(population);
    let mut roll_out = TwinRollOut::<f64>::new(population, loss)?;
    let glucose = population.scaler().of(Signal::State(Compartment::Q1));
    let courses = roll_out.courses(&parameters_of(network), &windows);
    let unscaled =
        |course: Vec<f64>| course.into_iter().map(|q1| MgPerDl(glucose.unscale(q1))).collect();
    Ok(courses.into_iter().map(unscaled).collect())
}

/// The windows, which must be of one length.
fn same_length<'a>(
    windows: impl Iterator<Item = &'a PreparedWindow>,
) -> Result<Vec<&'a PreparedWindow>, TwinError> {
    let windows: Vec<&PreparedWindow> = windows.collect();
    let first = windows.first().ok_or(TwinError::NoWindows)?.steps();
    match windows.iter().find(|window| window.steps() != first) {
        Some(other) => Err(TwinError::UnequalWindows { first, other: other.steps() }),
        None => Ok(windows),
    }
}

fn mean_loss<T: Precision>(
    roll_out: &mut TwinRollOut<T>,
    parameters: &[T],
    windows: &[&PreparedWindow],
) -> f64 {
    roll_out.loss(parameters, windows, None) / windows.len() as f64
}

fn finite(loss: f64, epoch: usize) -> Result<f64, TwinError> {
    if loss.is_finite() { Ok(loss) } else { Err(TwinError::Diverged(epoch)) }
}

/// Fisher and Yates.
fn shuffle(order: &mut [usize], rng: &mut ChaCha8Rng) {
    for i in (1..order.len()).rev() {
        order.swap(i, rng.random_range(0..=i));
    }
}
