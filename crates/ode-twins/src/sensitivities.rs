//! Bayesian optimisation of the three insulin sensitivities (paper, "Bayesian optimization-based
//! digital twin").

use egobox_ego::{Cstr, EgorServiceFactory};
use ndarray::Array2;
use ode_sim::{OdeParameters, OdePlant};
use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::error::OdeTwinError;
use crate::windows::FitWindows;

/// S_f1, S_f2, S_f3.
const SENSITIVITIES: usize = 3;

/// How the sensitivities are searched for.
///
/// The paper names the method and the parameters and leaves range and number of evaluations open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensitivitySearch {
    /// Evaluations of a Latin hypercube, before there is anything to model.
    pub explore: usize,
    /// Evaluations that a Gaussian process proposes.
    pub propose: usize,
    /// Least and greatest factor on each population sensitivity.
    pub range: (f64, f64),
}

impl SensitivitySearch {
    /// 15 and 25 evaluations within a fifth and five times the population's sensitivities.
    #[must_use]
    pub const fn paper() -> Self {
        Self { explore: 15, propose: 25, range: (0.2, 5.0) }
    }

    /// 10 and 8 evaluations.
    #[must_use]
    pub const fn quick() -> Self {
        Self { explore: 10, propose: 8, range: (0.2, 5.0) }
    }
}

/// What a search found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundSensitivities {
    /// Factors on the population's S_f1, S_f2 and S_f3.
    pub factors: [f64; SENSITIVITIES],
    /// Mean training loss.
    pub loss: f64,
    /// Evaluations made.
    pub evaluations: usize,
}

/// The population's parameters with three sensitivities multiplied.
#[must_use]
pub fn with_sensitivities(factors: [f64; SENSITIVITIES]) -> OdeParameters {
    let p = OdeParameters::nominal();
    let [f1, f2, f3] = factors;
    OdeParameters { s_f1: p.s_f1 * f1, s_f2: p.s_f2 * f2, s_f3: p.s_f3 * f3, ..p }
}

/// The sensitivities with the least training loss that the search met.
///
/// The optimiser sees logarithms of factors and of losses. A factor whose plant cannot be simulated
/// counts as twice the worst loss so far.
///
/// # Errors
/// [`OdeTwinError::Setting`] for a range that cannot be, [`OdeTwinError::Search`] if the optimiser
/// refuses, [`OdeTwinError::NoCandidate`] if no evaluation succeeds.
pub fn search_sensitivities(
    windows: &FitWindows<'_>,
    rule: &SensitivitySearch,
    seed: u64,
) -> Result<FoundSensitivities, OdeTwinError> {
    let (least, most) = rule.range;
    if !(least > 0.0 && least < most && most.is_finite()) {
        let requirement = "positive and below the greatest factor";
        return Err(OdeTwinError::Setting { setting: "least factor", value: least, requirement });
    }
    let (low, high) = (least.ln(), most.ln());
    let mut tried: Vec<([f64; SENSITIVITIES], Option<f64>)> = Vec::new();
    let mut last = String::from("no evaluation was asked for");
    let mut points = hypercube(rule.explore.max(1), low, high, seed);
    points.reverse();
    for number in 0..rule.explore.max(1) + rule.propose {
        let point = match points.pop() {
            Some(point) => point,
            None => propose(&tried, low, high, seed.wrapping_add(number as u64))?,
        };
        let parameters = with_sensitivities(point.map(f64::exp));
        let loss = match windows.loss(&OdePlant::reproduction(parameters, windows.weight())) {
            Ok(loss) if loss.is_finite() && loss > 0.0 => Some(loss),
            Ok(loss) => {
                last = format!("the loss is {loss}");
                None
            }
            Err(error) => {
                last = error.to_string();
                None
            }
        };
        tried.push((point, loss));
    }
    let found = tried.iter().filter_map(|(point, loss)| Some((*point, (*loss)?)));
    let best = found.min_by(|a, b| a.1.total_cmp(&b.1));
    let (point, loss) = best.ok_or(OdeTwinError::NoCandidate { tried: tried.len(), last })?;
    Ok(FoundSensitivities { factors: point.map(f64::exp), loss, evaluations: tried.len() })
}

/// Where to look next.
fn propose(
    tried: &[([f64; SENSITIVITIES], Option<f64>)],
    low: f64,
    high: f64,
    seed: u64,
) -> Result<[f64; SENSITIVITIES], OdeTwinError> {
    let worst = tried.iter().filter_map(|(_, loss)| *loss).fold(1e-6, f64::max);
    let x = Array2::from_shape_fn((tried.len(), SENSITIVITIES), |(row, k)| tried[row].0[k]);
    let y = Array2::from_shape_fn((tried.len(), 1), |(row, _)| {
        tried[row].1.unwrap_or(2.0 * worst).ln()
    });
    let limits = Array2::from_shape_fn((SENSITIVITIES, 2), |(_, end)| [low, high][end]);
    let search = EgorServiceFactory::<Cstr>::optimize()
        .configure(|config| config.seed(seed))
        .min_within(&limits)
        .map_err(|error| OdeTwinError::Search(error.to_string()))?;
    let proposed = search.suggest(&x, &y);
    Ok(std::array::from_fn(|k| proposed[(0, k)].clamp(low, high)))
}

/// Points of which each coordinate has one in each equal part of its range.
fn hypercube(points: usize, low: f64, high: f64, seed: u64) -> Vec<[f64; SENSITIVITIES]> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn = vec![[0.0; SENSITIVITIES]; points];
    for coordinate in 0..SENSITIVITIES {
        let mut parts: Vec<usize> = (0..points).collect();
        parts.shuffle(&mut rng);
        for (point, part) in drawn.iter_mut().zip(parts) {
            let share = (part as f64 + rng.random::<f64>()) / points as f64;
            point[coordinate] = low + share * (high - low);
        }
    }
    drawn
}
