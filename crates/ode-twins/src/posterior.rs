//! Maximum a posteriori and the posterior itself: six factors of a person, with priors.

mod sample;

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use ode_sim::OdeParameters;
use ode_sim::personal::{FACTORS, PersonalFactors};

use crate::density::{ErrorModel, Errors, errors, factors_of, linearised, log_density};
use crate::error::OdeTwinError;
use crate::windows::FitWindows;

pub use sample::{ChainDiagnostics, Posterior, Sampling, sample_posterior};

/// Iterations after which a search is given up.
const MOST_ITERATIONS: usize = 40;
/// A step shorter than this many posterior standard deviations ends the search.
const TOLERANCE: f64 = 0.01;

/// The most probable factors of a person.
#[derive(Debug, Clone, PartialEq)]
pub struct MaximumAPosteriori {
    /// Log factors on the population's parameters.
    pub factors: PersonalFactors,
    /// Standard deviation of what half an hour adds to a run's error, mg/dL.
    pub sigma: f64,
    /// Share of the error that is left after half an hour.
    pub autoregression: f64,
    /// Whether the search came to rest.
    pub converged: bool,
    /// Factors in prior standard deviations.
    pub(crate) standard: [f64; FACTORS],
    pub(crate) model: ErrorModel,
    /// Lower Cholesky factor of the covariance of `standard`, row-major.
    pub(crate) root: [[f64; FACTORS]; FACTORS],
    /// Half hours, the number of observations.
    pub(crate) observations: usize,
}

impl MaximumAPosteriori {
    /// The person's parameters.
    #[must_use]
    pub fn parameters(&self) -> OdeParameters {
        self.factors.applied_to(&OdeParameters::nominal())
    }
}

/// The most probable factors given the windows that do not overlap, by Gauss-Newton steps with the
/// error model fitted anew in between; priors as [`Factor::prior_sd`](ode_sim::personal::Factor::prior_sd)
/// says.
///
/// # Errors
/// Those of the simulation at the population's parameters and at each accepted step.
pub fn maximum_a_posteriori(windows: &FitWindows<'_>) -> Result<MaximumAPosteriori, OdeTwinError> {
    let mut standard = [0.0; FACTORS];
    let (mut at, mut slopes) = linearised(windows, &standard)?;
    let mut model = ErrorModel::fitted(&at);
    let mut converged = false;
    let mut information = Mat::identity(FACTORS, FACTORS);
    for _ in 0..MOST_ITERATIONS {
        let (matrix, right) = normal_equations(&at, &slopes, &standard, &model);
        information = matrix;
        let factor = information.llt(Side::Lower).map_err(|_| OdeTwinError::Information)?;
        let step = factor.solve(&right);
        let length = (step.transpose() * &information * &step)[(0, 0)].sqrt();
        let now = log_density(&at, &standard, &model);
        let mut share = 1.0;
        let accepted = loop {
            let trial: [f64; FACTORS] = std::array::from_fn(|k| standard[k] + share * step[(k, 0)]);
            if let Ok(errors) = errors(windows, &trial)
                && log_density(&errors, &trial, &model) > now
            {
                break Some(trial);
            }
            share *= 0.5;
            if share < 1e-3 {
                break None;
            }
        };
        converged = share * length < TOLERANCE || accepted.is_none();
        if let Some(trial) = accepted {
            standard = trial;
            (at, slopes) = linearised(windows, &standard)?;
            model = ErrorModel::fitted(&at);
        }
        if converged {
            break;
        }
    }
    let covariance = information
        .llt(Side::Lower)
        .map_err(|_| OdeTwinError::Information)?
        .solve(Mat::<f64>::identity(FACTORS, FACTORS));
    let root = covariance.llt(Side::Lower).map_err(|_| OdeTwinError::Information)?;
    let root = std::array::from_fn(|i| std::array::from_fn(|j| root.L()[(i, j)]));
    Ok(MaximumAPosteriori {
        factors: factors_of(&standard),
        sigma: model.sigma(),
        autoregression: model.coefficient(),
        converged,
        standard,
        model,
        root,
        observations: at.iter().map(|window| window.len() - 1).sum(),
    })
}

/// Curvature and slope of the log density by the factors, errors taken as linear in them.
fn normal_equations(
    errors: &[Vec<f64>],
    slopes: &[Errors; FACTORS],
    standard: &[f64; FACTORS],
    model: &ErrorModel,
) -> (Mat<f64>, Mat<f64>) {
    let mut matrix = Mat::<f64>::identity(FACTORS, FACTORS);
    let mut right = Mat::from_fn(FACTORS, 1, |k, _| -standard[k]);
    let precision = model.sigma().powi(-2);
    for (index, window) in errors.iter().enumerate() {
        let white = model.whitened(window);
        let columns = slopes.each_ref().map(|slope| model.whitened(&slope[index]));
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        for i in 0..FACTORS {
            right[(i, 0)] -= precision * product(&columns[i], &white);
            for j in 0..FACTORS {
                matrix[(i, j)] += precision * product(&columns[i], &columns[j]);
            }
        }
    }
    (matrix, right)
}
