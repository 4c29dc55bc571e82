//! Bayesian optimisation of the three insulin sensitivities (paper, "Bayesian optimization-based
//! digital twin").

use bayesopt::{Range, latin_hypercube};
use ode_sim::{OdeParameters, OdePlant};

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
    let ranges = [Range::new(least.ln(), most.ln()).map_err(OdeTwinError::Search)?; SENSITIVITIES];
    let mut tried: Vec<Trial> = Vec::new();
    let mut points = latin_hypercube(&ranges, rule.explore.max(1), seed);
    points.reverse();
    for number in 0..rule.explore.max(1) + rule.propose {
        let point = match points.pop() {
            Some(point) => point,
            None => propose(&tried, &ranges, seed.wrapping_add(number as u64))?,
        };
        let parameters = with_sensitivities(factors(&point));
        let loss = match windows.loss(&OdePlant::reproduction(parameters, windows.weight())) {
            Ok(loss) if loss.is_finite() && loss > 0.0 => Ok(loss),
            Ok(loss) => Err(format!("the loss is {loss}")),
            Err(error) => Err(error.to_string()),
        };
        tried.push((point, loss));
    }
    let found = tried.iter().filter_map(|(point, loss)| Some((point, *loss.as_ref().ok()?)));
    let best = found.min_by(|a, b| a.1.total_cmp(&b.1));
    let (point, loss) = best.ok_or_else(|| {
        let last = tried.last().and_then(|(_, loss)| loss.clone().err()).unwrap_or_default();
        OdeTwinError::NoCandidate { tried: tried.len(), last }
    })?;
    Ok(FoundSensitivities { factors: factors(point), loss, evaluations: tried.len() })
}

/// Logarithms of factors, and their loss or why there is none.
type Trial = (Vec<f64>, Result<f64, String>);

fn factors(point: &[f64]) -> [f64; SENSITIVITIES] {
    std::array::from_fn(|k| point[k].exp())
}

/// Where to look next.
fn propose(tried: &[Trial], ranges: &[Range], seed: u64) -> Result<Vec<f64>, OdeTwinError> {
    let losses = tried.iter().filter_map(|(_, loss)| loss.as_ref().ok());
    let worst = losses.copied().fold(1e-6, f64::max);
    let log_loss = |loss: &Result<f64, String>| loss.as_ref().map_or(2.0 * worst, |l| *l).ln();
    let logs: Vec<(Vec<f64>, f64)> =
        tried.iter().map(|(point, loss)| (point.clone(), log_loss(loss))).collect();
    bayesopt::propose(&logs, ranges, seed).map_err(OdeTwinError::Search)
}
