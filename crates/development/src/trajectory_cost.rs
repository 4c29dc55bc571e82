//! What a change of one sub-network does to simulated glucose: the cost by which `verify --repair` chooses.

use conformance::{ChangeCost, OneHiddenLayer};
use nn_statespace::{GlucoseClamp, HiddenLayerNetwork, PerCompartment, PopulationModel, Signal};
use ode_sim::DevelopmentSet;
use ode_sim::development_set::{Subset, Week};
use physiology::{Compartment, OpenLoop, Plant as _, STEP, simulate};
use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::error::DevelopmentError;
use crate::weeks::{WINDOW, Window, windows_of};

/// Weeks of a subset that windows are drawn from.
pub const WEEKS: usize = 400;
/// Most windows of one of the paper's groups.
const WINDOWS: usize = 2000;
/// Of so many steps one is counted.
const EVERY: usize = 3;
/// Windows that one task sums up; fixed, so that sums do not depend on the number of threads.
const TOGETHER: usize = 10;
/// Share of the curvature of glucose, as means of diagonals, that the output of the network itself is given at the starts of
/// the windows: what hardly moves glucose is not to move without need.
const OWN_SHARE: f64 = 1e-3;

/// Windows of training weeks beside the ODE.
pub struct TrajectoryCost {
    windows: Vec<Window>,
    /// Windows of each group.
    groups: [usize; 3],
}

/// Sums over windows: the value, the gradient, the upper triangle of the curvature, row by row.
struct Sums {
    value: f64,
    gradient: Vec<f64>,
    curvature: Vec<f64>,
}

impl TrajectoryCost {
    /// Draws windows from training weeks of a development set, which are drawn first: as many of each of the paper's groups
    /// as there are, at most 2000.
    ///
    /// # Errors
    /// A week that cannot be simulated.
    pub fn new(set: &DevelopmentSet, seed: u64) -> Result<Self, DevelopmentError> {
        let mut by_group: [Vec<Window>; 3] = Default::default();
        for week in drawn_weeks(set, Subset::Train, WEEKS, seed)? {
            for window in windows_of(set, &week)? {
                by_group[window.group as usize].push(window);
            }
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for windows in &mut by_group {
            windows.shuffle(&mut rng);
            windows.truncate(WINDOWS);
        }
        let groups = [0, 1, 2].map(|group| by_group[group].len());
        Ok(Self { windows: by_group.into_iter().flatten().collect(), groups })
    }

    /// Mean squared error of glucose over the groups, (mg/dL)², and its change with the output weights of `compartment`'s
    /// network, which is `network` in the place of the model's own (Gauss-Newton).
    ///
    /// # Errors
    /// A network that does not fit, and a window in which a step fails.
    pub fn of(
        &self,
        model: &PopulationModel,
        compartment: Compartment,
        network: &OneHiddenLayer,
    ) -> Result<ChangeCost, DevelopmentError> {
        let model = with_network(model, compartment, network)?.with_clamp(GlucoseClamp::Off);
        let n = network.hidden() + 1;
        let parts: Vec<Sums> = self
            .windows
            .par_chunks(TOGETHER)
            .map(|windows| {
                let mut sums = Sums::zero(n);
                for window in windows {
                    self.add(&mut sums, &model, compartment, window)?;
                }
                Ok(sums)
            })
            .collect::<Result<_, DevelopmentError>>()?;
        let mut sums = Sums::zero(n);
        for part in &parts {
            sums.plus(part);
        }
        let points = self.points_of(&model, compartment);
        let own = ChangeCost::of_output(network, network, &points)?.curvature();
        let diagonal = |curvature: &[f64]| curvature.iter().step_by(n + 1).sum::<f64>();
        let share = OWN_SHARE * diagonal(&sums.curvature) / diagonal(&own);
        let curvature: Vec<f64> = (0..n * n)
            .map(|index| {
                let (row, column) = (index / n, index % n);
                sums.curvature[row.min(column) * n + row.max(column)] + share * own[index]
            })
            .collect();
        Ok(ChangeCost::new(network, sums.value, sums.gradient, &curvature)?)
    }

    /// One window: the model from its start, and how glucose moves with each output weight.
    fn add(
        &self,
        sums: &mut Sums,
        model: &PopulationModel,
        compartment: Compartment,
        window: &Window,
    ) -> Result<(), DevelopmentError> {
        let present = self.groups.iter().filter(|windows| **windows > 0).count();
        let share = 1.0 / (present * self.groups[window.group as usize] * (WINDOW / EVERY)) as f64;
        let unit = model.scaler().of(Signal::State(Compartment::Q1)).scale;
        let network = model.network(compartment);
        let n = network.hidden() + 1;
        let start = model.scaler().scale(&window.start);
        let mut inputs = OpenLoop::new(&window.inputs);
        let run = simulate(model, start, &mut inputs, window.inputs.len())?;
        // Tangents of each state by each output weight along the run; all zero at the start.
        let mut tangents = PerCompartment::from_fn(|_| vec![0.0; n]);
        for (step, truth) in window.glucose.iter().enumerate() {
            let state = &run.states[step];
            let u = model.scaler().scale_input(&window.inputs[step]);
            let slopes = PerCompartment::from_fn(|c| model.rate_and_slopes(c, state, u).1);
            let seen = model.seen_by(compartment, state, u);
            let mut next = tangents.clone();
            for (of, slopes) in slopes.iter() {
                for (by, slope) in slopes.iter().filter(|(_, slope)| **slope != 0.0) {
                    for (next, tangent) in next[of].iter_mut().zip(&tangents[by]) {
                        *next += STEP.0 * slope * tangent;
                    }
                }
            }
            for (hidden, next) in next[compartment].iter_mut().enumerate() {
                *next +=
                    STEP.0 * if hidden + 1 == n { 1.0 } else { active(network, hidden, &seen) };
            }
            tangents = next;
            if (step + 1).is_multiple_of(EVERY) {
                let error = model.glucose(&run.states[step + 1]).0 - truth;
                sums.take(error, unit, share, &tangents[Compartment::Q1]);
            }
        }
        Ok(())
    }

    /// What a network sees at the starts of the windows.
    fn points_of(&self, model: &PopulationModel, compartment: Compartment) -> Vec<Vec<f64>> {
        let scaler = model.scaler();
        let seen = |window: &Window| {
            let u = scaler.scale_input(&window.inputs[0]);
            model.seen_by(compartment, &scaler.scale(&window.start), u)
        };
        self.windows.iter().map(seen).collect()
    }
}

impl Sums {
    fn zero(n: usize) -> Self {
        Self { value: 0.0, gradient: vec![0.0; n], curvature: vec![0.0; n * n] }
    }

    /// Adds a sample: its error in mg/dL and the tangent of scaled glucose, of which one is `unit` mg/dL.
    fn take(&mut self, error: f64, unit: f64, share: f64, tangent: &[f64]) {
        let n = tangent.len();
        self.value += share * error * error;
        for (row, by) in tangent.iter().enumerate() {
            let by = 2.0 * share * unit * by;
            self.gradient[row] += by * error;
            let columns = &mut self.curvature[row * n + row..(row + 1) * n];
            for (sum, other) in columns.iter_mut().zip(&tangent[row..]) {
                *sum += by * unit * other;
            }
        }
    }

    fn plus(&mut self, other: &Self) {
        self.value += other.value;
        for (own, more) in
            [(&mut self.gradient, &other.gradient), (&mut self.curvature, &other.curvature)]
        {
            for (own, more) in own.iter_mut().zip(more) {
                *own += more;
            }
        }
    }
}

/// A hidden unit after its ReLU.
fn active(network: &HiddenLayerNetwork, unit: usize, seen: &[f64]) -> f64 {
    let weights = &network.w1()[unit * network.inputs()..(unit + 1) * network.inputs()];
    let sum: f64 = weights.iter().zip(seen).map(|(w, x)| w * x).sum();
    (sum + network.b1()[unit]).max(0.0)
}

/// As many weeks of a subset, drawn from the whole set, or all if there are fewer.
///
/// # Errors
/// A week that cannot be drawn.
pub fn drawn_weeks(
    set: &DevelopmentSet,
    subset: Subset,
    count: usize,
    seed: u64,
) -> Result<Vec<Week>, DevelopmentError> {
    let mut indices: Vec<usize> = (0..set.len()).collect();
    indices.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let own =
        |index| set.week(index).map(|week| (week.subset == subset).then_some(week)).transpose();
    Ok(indices.into_iter().filter_map(own).take(count).collect::<Result<_, _>>()?)
}

/// The model with another network in one place.
///
/// # Errors
/// A network of other shapes.
pub fn with_network(
    model: &PopulationModel,
    compartment: Compartment,
    network: &OneHiddenLayer,
) -> Result<PopulationModel, DevelopmentError> {
    let rows = (0..network.hidden()).flat_map(|unit| network.input_weights(unit).to_vec());
    let changed = HiddenLayerNetwork::new(
        network.inputs().len(),
        rows.collect(),
        network.hidden_biases().to_vec(),
        network.output_weights().to_vec(),
        network.output_bias(),
    )?;
    let networks = PerCompartment::from_fn(|c| {
        if c == compartment { changed.clone() } else { model.network(c).clone() }
    });
    let (wiring, card) = (model.wiring().clone(), model.card().clone());
    Ok(PopulationModel::new(wiring, networks, *model.scaler(), model.clamp(), card)?)
}
