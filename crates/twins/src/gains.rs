//! How strongly one person answers to doses.
//!
//! A residual network that keeps physiology's signs can add to what insulin does and cannot take from
//! it, so that somebody less sensitive than the population is out of its reach. Gains of their own on
//! insulin and carbohydrate, before the population's networks, can do both, and keep every sign: a positive
//! factor changes no slope's sign.

use std::sync::Arc;

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use nn_statespace::{DoseGains, PopulationModel, ScaledStates, Signal};
use physiology::{Compartment, STEPS_PER_HOUR, StepInput};

use crate::error::TwinError;
use crate::inputs::InputSet;
use crate::prepared::PreparedWindow;
use crate::residual::ResidualNetwork;
use crate::roll_out::simulate_many;
use crate::twin::{Twin, TwinCard};

/// Whether a person's twin has gains of its own on doses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Doses {
    /// The population's (paper).
    Population,
    /// Gains on insulin and carbohydrate are fitted to the training windows before the residual
    /// network is trained.
    Scaled,
}

/// What was fitted to a person's windows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fitted {
    pub(crate) gains: DoseGains,
    /// A constant rate beside the population's dQ1/dt, scaled units per minute: where the residual network
    /// begins.
    pub(crate) rate: f64,
}

/// Logarithms of both gains, and the rate, mg/dL per minute.
type Unknowns = [f64; UNKNOWNS];
const UNKNOWNS: usize = 3;
/// Standard deviations of what is known beforehand.
const PRIOR: Unknowns = [0.5, 0.5, 0.3];
/// Differences for slopes, in the same units.
const STEP: Unknowns = [0.05, 0.05, 0.05];
/// Gains stay within this factor and its inverse.
const LARGEST: f64 = 4.0;
/// Steps between errors that count.
const SPACING: usize = STEPS_PER_HOUR / 2;
const MOST_ROUNDS: usize = 12;
/// The fit ends when a round moves no unknown by more than this share of its prior's deviation.
const SETTLED: f64 = 0.01;

/// Gains and a constant rate that make the population model's free runs through a person's windows err
/// least, under priors about the population: damped Gauss-Newton steps on
/// `hours / 2 ln(mean squared error) + prior`, with `hours` the time that the windows cover and one error
/// an hour taken for independent.
///
/// `starts` gives the windows' starts in a body with some gains.
pub(crate) fn fit(
    population: &Arc<PopulationModel>,
    windows: &[PreparedWindow],
    hours: f64,
    starts: &dyn Fn(&PopulationModel) -> Result<Vec<ScaledStates>, TwinError>,
) -> Result<Fitted, TwinError> {
    let search = Search { population, windows, hours, starts };
    let mut at = [0.0; UNKNOWNS];
    let Some(mut errors) = search.errors(&at)? else {
        return Ok(Fitted { gains: DoseGains::NONE, rate: 0.0 });
    };
    for _ in 0..MOST_ROUNDS {
        let Some(step) = search.step(&at, &errors)? else { break };
        let now = search.misfit(&at, &errors);
        let mut share = 1.0;
        let better = loop {
            let there = std::array::from_fn(|k| within(k, at[k] + share * step[k]));
            let found = search.errors(&there)?;
            if let Some(found) = found.filter(|found| search.misfit(&there, found) < now) {
                break Some((there, found));
            }
            share *= 0.5;
            if share < 0.05 {
                break None;
            }
        };
        let Some((there, found)) = better else { break };
        let moved = (0..UNKNOWNS).map(|k| (there[k] - at[k]).abs() / PRIOR[k]);
        let moved = moved.fold(0.0, f64::max);
        (at, errors) = (there, found);
        if moved < SETTLED {
            break;
        }
    }
    Ok(Fitted { gains: gains(&at), rate: search.scaled_rate(&at) })
}

fn gains(at: &Unknowns) -> DoseGains {
    DoseGains { insulin: at[0].exp(), carbs: at[1].exp() }
}

fn within(k: usize, value: f64) -> f64 {
    let most = if k < 2 { LARGEST.ln() } else { 5.0 * PRIOR[k] };
    value.clamp(-most, most)
}

struct Search<'a> {
    population: &'a Arc<PopulationModel>,
    windows: &'a [PreparedWindow],
    hours: f64,
    starts: &'a dyn Fn(&PopulationModel) -> Result<Vec<ScaledStates>, TwinError>,
}

impl Search<'_> {
    fn scaled_rate(&self, at: &Unknowns) -> f64 {
        at[2] / self.population.scaler().of(Signal::State(Compartment::Q1)).scale
    }

    /// Errors of free runs at every [`SPACING`]-th step, mg/dL; `None` where a run leaves the finite numbers.
    fn errors(&self, at: &Unknowns) -> Result<Option<Vec<f64>>, TwinError> {
        let glucose = self.population.scaler().of(Signal::State(Compartment::Q1));
        let mut residual = ResidualNetwork::zeros();
        residual.add_to_output(self.scaled_rate(at));
        let population = PopulationModel::clone(self.population).with_dose_gains(gains(at))?;
        let twin = Twin {
            population: Arc::new(population),
            residual,
            heart_rate_scaler: None,
            inputs: InputSet::None,
            card: TwinCard::default(),
        };
        let starts = (self.starts)(&twin.population)?;
        let inputs: Vec<&[StepInput]> = self.windows.iter().map(PreparedWindow::inputs).collect();
        let runs = match simulate_many(&twin, &starts, &inputs) {
            Ok(runs) => runs,
            Err(TwinError::Simulation(_)) => return Ok(None),
            Err(error) => return Err(error),
        };
        let errors = runs.iter().zip(self.windows).flat_map(|(run, window)| {
            let pairs = run.iter().zip(window.target()).skip(SPACING).step_by(SPACING);
            pairs.map(|(found, target)| found.0 - glucose.unscale(*target))
        });
        Ok(Some(errors.collect()))
    }

    fn misfit(&self, at: &Unknowns, errors: &[f64]) -> f64 {
        let prior: f64 = at.iter().zip(PRIOR).map(|(value, sd)| 0.5 * (value / sd).powi(2)).sum();
        0.5 * self.hours * mean_square(errors).ln() + prior
    }

    /// The full Gauss-Newton step; `None` where slopes cannot be had.
    fn step(&self, at: &Unknowns, errors: &[f64]) -> Result<Option<Unknowns>, TwinError> {
        let mut slopes = Vec::with_capacity(UNKNOWNS);
        for k in 0..UNKNOWNS {
            let mut there = *at;
            there[k] += STEP[k];
            let Some(moved) = self.errors(&there)? else { return Ok(None) };
            let slope = moved.iter().zip(errors).map(|(m, e)| (m - e) / STEP[k]);
            slopes.push(slope.collect::<Vec<f64>>());
        }
        let weight = self.hours / (errors.len() as f64 * mean_square(errors));
        let dot = |a: &[f64], b: &[f64]| weight * a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let curvature = Mat::from_fn(UNKNOWNS, UNKNOWNS, |i, k| {
            let prior = if i == k { PRIOR[k].powi(-2) } else { 0.0 };
            dot(&slopes[i], &slopes[k]) + prior
        });
        let downhill =
            Mat::from_fn(UNKNOWNS, 1, |k, _| -dot(&slopes[k], errors) - at[k] * PRIOR[k].powi(-2));
        let Ok(factors) = curvature.llt(Side::Lower) else { return Ok(None) };
        let step = factors.solve(&downhill);
        Ok(Some(std::array::from_fn(|k| step[(k, 0)])))
    }
}

fn mean_square(errors: &[f64]) -> f64 {
    let sum: f64 = errors.iter().map(|error| error * error).sum();
    // Runs that hit every reading would make the logarithm endless.
    (sum / errors.len() as f64).max(1e-6)
}
