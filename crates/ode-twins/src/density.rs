//! The posterior density of a person's factors, given free runs of five hours.
//!
//! A free run starts at a reading, so that its error starts at zero and then grows. Errors are looked
//! at every half hour and modelled as an autoregression that starts at rest,
//! `e_k = a e_(k-1) + sigma w_k` with `e_0 = 0` and independent standard normal `w`. Every five
//! minutes errors are so smooth that an autoregression of any order there claims a precision that
//! no plant has; taking them for independent would claim sixty observations where there are a few.

use ode_sim::personal::{FACTORS, Factor, PersonalFactors};
use ode_sim::{OdeParameters, OdePlant};

use crate::error::OdeTwinError;
use crate::windows::FitWindows;

/// Width of the one-sided differences by factors, in prior standard deviations: rounding and
/// curvature both stay below a millionth of a slope.
const DIFFERENCE: f64 = 1e-5;

/// Steps between errors that count: half an hour.
const SPACING: usize = 6;

/// Prior of the logarithm of sigma: mean (of 20 mg/dL in half an hour) and SD.
const LOG_SIGMA: (f64, f64) = (3.0, 1.0);
/// Prior of the inverse hyperbolic tangent of the coefficient: mean and SD.
const COEFFICIENT: (f64, f64) = (1.2, 0.8);

/// Parameters of the error's autoregression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ErrorModel {
    /// log sigma (of mg/dL), and atanh of the coefficient: any number is allowed.
    pub(crate) unbounded: [f64; ERRORS],
}

/// Parameters of the error model.
pub(crate) const ERRORS: usize = 2;
/// All that is sampled: factors, then the error model.
pub(crate) const DIMENSION: usize = FACTORS + ERRORS;

impl ErrorModel {
    pub(crate) fn sigma(&self) -> f64 {
        self.unbounded[0].exp()
    }

    /// a; stationary whatever the parameters.
    pub(crate) fn coefficient(&self) -> f64 {
        self.unbounded[1].tanh()
    }

    /// The model that fits some errors best, by least squares, each window starting at zero. Its
    /// prior does not count.
    pub(crate) fn fitted(errors: &[Vec<f64>]) -> Self {
        let pairs =
            || errors.iter().flat_map(|window| window.windows(2)).map(|pair| (pair[0], pair[1]));
        let (mut xx, mut xy) = (0.0, 0.0);
        for (before, now) in pairs() {
            xx += before * before;
            xy += before * now;
        }
        // With room for the inverse hyperbolic tangent.
        let coefficient = if xx > 0.0 { (xy / xx).clamp(-0.98, 0.98) } else { 0.0 };
        let (mut squares, mut steps) = (0.0, 0.0);
        for (before, now) in pairs() {
            squares += (now - coefficient * before).powi(2);
            steps += 1.0;
        }
        let variance = f64::max(squares / f64::max(steps, 1.0), 1e-6);
        Self { unbounded: [0.5 * variance.ln(), coefficient.atanh()] }
    }

    /// The part of each error that the one before it does not tell, mg/dL; the start is left out.
    pub(crate) fn whitened(&self, errors: &[f64]) -> Vec<f64> {
        let a = self.coefficient();
        errors.windows(2).map(|pair| pair[1] - a * pair[0]).collect()
    }
}

/// Factors in units of their prior's standard deviation.
pub(crate) fn factors_of(standard: &[f64]) -> PersonalFactors {
    let mut factors = PersonalFactors::default();
    for ((value, standard), factor) in factors.0.iter_mut().zip(standard).zip(Factor::ALL) {
        *value = standard * factor.prior_sd();
    }
    factors
}

/// Measured minus simulated every half hour, mg/dL, for each window, the start (zero) first.
pub(crate) type Errors = Vec<Vec<f64>>;

/// The errors of free runs under factors in prior standard deviations.
pub(crate) fn errors(windows: &FitWindows<'_>, standard: &[f64]) -> Result<Errors, OdeTwinError> {
    let parameters = factors_of(standard).applied_to(&OdeParameters::nominal());
    let simulated = windows.simulated(&OdePlant::reproduction(parameters, windows.weight()))?;
    let pairs = simulated.into_iter().zip(&windows.measured);
    let errors = pairs.map(|(simulated, measured)| {
        measured.iter().zip(simulated).step_by(SPACING).map(|(m, s)| m - s).collect()
    });
    Ok(errors.collect())
}

/// The errors of free runs under factors in prior standard deviations, and the slopes of these
/// errors by each factor, mg/dL per prior standard deviation.
pub(crate) fn linearised(
    windows: &FitWindows<'_>,
    standard: &[f64],
) -> Result<(Errors, [Errors; FACTORS]), OdeTwinError> {
    let at = errors(windows, standard)?;
    let mut slopes: [Errors; FACTORS] = Default::default();
    for (factor, slope) in slopes.iter_mut().enumerate() {
        let mut moved = standard.to_vec();
        moved[factor] += DIFFERENCE;
        for (moved, errors) in errors(windows, &moved)?.iter().zip(&at) {
            slope.push(moved.iter().zip(errors).map(|(a, b)| (a - b) / DIFFERENCE).collect());
        }
    }
    Ok((at, slopes))
}

/// Log of the posterior density up to a constant, without slopes.
pub(crate) fn log_density(errors: &[Vec<f64>], standard: &[f64], model: &ErrorModel) -> f64 {
    let mut sum = log_prior(standard, model);
    for window in errors {
        for white in model.whitened(window) {
            sum -= 0.5 * (white / model.sigma()).powi(2) + model.unbounded[0];
        }
    }
    sum
}

/// Log of the posterior density up to a constant at `position` (factors in prior standard
/// deviations, then the error model); its slopes go into `slopes`.
pub(crate) fn log_density_with_slopes(
    windows: &FitWindows<'_>,
    position: &[f64],
    slopes: &mut [f64],
) -> Result<f64, OdeTwinError> {
    let (standard, rest) = position.split_at(FACTORS);
    let model = ErrorModel { unbounded: std::array::from_fn(|k| rest[k]) };
    let (errors, by_factors) = linearised(windows, standard)?;
    for (slope, value) in slopes.iter_mut().zip(standard) {
        *slope = -value;
    }
    for ((slope, value), (mean, sd)) in
        slopes[FACTORS..].iter_mut().zip(rest).zip([LOG_SIGMA, COEFFICIENT])
    {
        *slope = -(value - mean) / (sd * sd);
    }
    let precision = model.sigma().powi(-2);
    let by_unbounded = 1.0 - model.coefficient().powi(2);
    for (index, window) in errors.iter().enumerate() {
        let white = model.whitened(window);
        for (factor, by_factor) in by_factors.iter().enumerate() {
            let moved = model.whitened(&by_factor[index]);
            let product: f64 = white.iter().zip(&moved).map(|(w, m)| w * m).sum();
            slopes[factor] -= precision * product;
        }
        for (before, white) in window.iter().zip(&white) {
            slopes[FACTORS] += precision * white * white - 1.0;
            slopes[FACTORS + 1] += precision * white * by_unbounded * before;
        }
    }
    Ok(log_density(&errors, standard, &model))
}

fn log_prior(standard: &[f64], model: &ErrorModel) -> f64 {
    let factors: f64 = standard.iter().map(|value| 0.5 * value * value).sum();
    let errors = model.unbounded.iter().zip([LOG_SIGMA, COEFFICIENT]);
    let errors: f64 = errors.map(|(value, (mean, sd))| 0.5 * ((value - mean) / sd).powi(2)).sum();
    -factors - errors
}

#[cfg(test)]
mod tests {
    use rand::RngExt as _;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng as _;

    use super::*;

    #[test]
    fn an_autoregression_is_found_again_and_whitened() {
        let coefficient = 0.8;
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let noise: Vec<f64> = (0..200 * 10).map(|_| rng.random_range(-1.0..1.0)).collect();
        let errors: Vec<Vec<f64>> = noise
            .chunks(10)
            .map(|drive| {
                let mut series = vec![0.0];
                for (k, drive) in drive.iter().enumerate() {
                    series.push(coefficient * series[k] + 9.0 * drive);
                }
                series
            })
            .collect();
        let model = ErrorModel::fitted(&errors);
        // 2,000 steps: standard errors of about 0.013, and of 1 % of 9 / sqrt(3).
        assert!((model.coefficient() - coefficient).abs() < 0.05, "{model:?}");
        assert!((model.sigma() - 9.0 / 3.0_f64.sqrt()).abs() < 0.3, "{model:?}");
        let exact = ErrorModel { unbounded: [0.0, coefficient.atanh()] };
        for (k, white) in exact.whitened(&errors[3]).into_iter().enumerate() {
            assert!((white - 9.0 * noise[30 + k]).abs() < 1e-9);
        }
    }
}
