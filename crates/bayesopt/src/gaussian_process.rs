//! A Gaussian process through the values of a function on the unit cube.

use std::f64::consts::SQRT_2;

use faer::linalg::solvers::{Llt, Solve as _};
use faer::{Mat, Side};

use crate::pattern_search::climb;

/// Range of the logarithms of length scales, in sides of the cube: a fiftieth to twenty.
const LOG_LENGTHS: (f64, f64) = (-3.9, 3.0);
/// Range of the logarithm of the noise's variance: rounding to a tenth.
const LOG_NOISE: (f64, f64) = (-18.0, -2.3);
/// First and last step of the search for the parameters, in logarithms.
const STEPS: (f64, f64) = (1.0, 0.1);

/// A process with mean 0, variance 1, a Matérn kernel of smoothness 5/2 with a length scale for each
/// coordinate, and noise.
pub(crate) struct GaussianProcess<'a> {
    points: &'a [Vec<f64>],
    lengths: Vec<f64>,
    factor: Llt<f64>,
    /// Inverse of the covariance times the values.
    weights: Mat<f64>,
}

impl<'a> GaussianProcess<'a> {
    /// The process with the most probable parameters.
    ///
    /// `points` lie in the unit cube; `values` have mean 0 and standard deviation 1. Length scales have the log-normal prior of
    /// Hvarfner et al. 2024 with mean sqrt(2) + ln(d)/2 and
    /// standard deviation sqrt(3) of the logarithm, so that few points claim little.
    pub(crate) fn fitted(points: &'a [Vec<f64>], values: &[f64]) -> Self {
        let coordinates = points.first().map_or(0, Vec::len);
        let median = SQRT_2 + 0.5 * (coordinates as f64).max(1.0).ln();
        let score = |parameters: &[f64]| {
            let (logs, noise) = parameters.split_at(coordinates);
            let prior: f64 = logs.iter().map(|log| (log - median).powi(2) / 6.0).sum();
            Self::with(points, values, logs, noise[0])
                .map_or(f64::NEG_INFINITY, |(_, likelihood)| likelihood - prior)
        };
        let [first, second] = [-1.2, 0.5].map(|log| {
            let mut parameters = vec![log; coordinates];
            parameters.push(-9.0);
            let top = climb(&mut parameters, (LOG_NOISE.0, LOG_LENGTHS.1), STEPS, score);
            (parameters, top)
        });
        let (parameters, _) = if second.1 > first.1 { second } else { first };
        let (logs, noise) = parameters.split_at(coordinates);
        let found = Self::with(points, values, logs, noise[0]);
        // A tenth of noise makes any covariance of a kernel positive definite.
        let last = || Self::with(points, values, logs, LOG_NOISE.1);
        found.or_else(last).map(|(process, _)| process).expect("positive definite with noise")
    }

    /// The process with these logarithms of lengths and noise, each clamped to its range, and the logarithm
    /// of its likelihood but for a constant; `None` where rounding leaves no positive definite matrix.
    fn with(
        points: &'a [Vec<f64>],
        values: &[f64],
        logs: &[f64],
        noise: f64,
    ) -> Option<(Self, f64)> {
        let lengths: Vec<f64> =
            logs.iter().map(|log| log.clamp(LOG_LENGTHS.0, LOG_LENGTHS.1).exp()).collect();
        let noise = noise.clamp(LOG_NOISE.0, LOG_NOISE.1).exp();
        let count = points.len();
        let covariance = Mat::from_fn(count, count, |row, column| {
            let own = if row == column { noise } else { 0.0 };
            matern(&points[row], &points[column], &lengths) + own
        });
        let factor = covariance.llt(Side::Lower).ok()?;
        let log_det = 2.0 * (0..count).map(|k| factor.L()[(k, k)].ln()).sum::<f64>();
        let right = Mat::from_fn(count, 1, |row, _| values[row]);
        let weights = factor.solve(&right);
        let product: f64 = (0..count).map(|k| weights[(k, 0)] * values[k]).sum();
        Some((Self { points, lengths, factor, weights }, -0.5 * (product + log_det)))
    }

    /// Mean and standard deviation of the function, without noise, at a point.
    pub(crate) fn at(&self, point: &[f64]) -> (f64, f64) {
        let count = self.points.len();
        let cross =
            Mat::from_fn(count, 1, |row, _| matern(&self.points[row], point, &self.lengths));
        let mean = (0..count).map(|k| cross[(k, 0)] * self.weights[(k, 0)]).sum();
        let solved = self.factor.solve(&cross);
        let known: f64 = (0..count).map(|k| cross[(k, 0)] * solved[(k, 0)]).sum();
        (mean, (1.0 - known).max(0.0).sqrt())
    }
}

/// The Matérn kernel of smoothness 5/2, 1 at distance 0 (Rasmussen and Williams 2006, Eq. 4.17).
fn matern(a: &[f64], b: &[f64], lengths: &[f64]) -> f64 {
    let square: f64 =
        a.iter().zip(b).zip(lengths).map(|((a, b), length)| ((a - b) / length).powi(2)).sum();
    let distance = (5.0 * square).sqrt();
    (1.0 + distance + 5.0 * square / 3.0) * (-distance).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_by_hand() {
        let at = |distance: f64| matern(&[0.0, 0.0], &[0.0, 2.0 * distance], &[1.0, 2.0]);
        assert_eq!(at(0.0), 1.0);
        // (1 + sqrt 5 + 5/3) exp(-sqrt 5) at one length.
        let one = (1.0 + 5.0f64.sqrt() + 5.0 / 3.0) * (-(5.0f64.sqrt())).exp();
        assert!((at(1.0) - one).abs() < 1e-15);
        assert!(at(1.0) < SQRT_2.recip() && at(3.0) < 0.03);
    }

    #[test]
    fn it_goes_through_what_it_knows_and_is_unsure_elsewhere() {
        let wave = |x: f64| SQRT_2 * (6.0 * x).sin();
        let points: Vec<Vec<f64>> = (0..9).map(|k| vec![k as f64 / 8.0]).collect();
        let values: Vec<f64> = points.iter().map(|p| wave(p[0])).collect();
        let process = GaussianProcess::fitted(&points, &values);
        for (point, value) in points.iter().zip(&values) {
            let (mean, sd) = process.at(point);
            assert!((mean - value).abs() < 0.02 && sd < 0.02, "{mean} for {value}, {sd}");
        }
        let between = process.at(&[0.4375]);
        assert!((between.0 - wave(0.4375)).abs() < 0.05, "{between:?}");
        assert!(between.1 > 1.5 * process.at(&[0.5]).1, "{between:?}");
    }

    #[test]
    fn a_coordinate_without_influence_gets_a_long_scale() {
        let points: Vec<Vec<f64>> =
            (0..25).map(|k| vec![(k % 5) as f64 / 4.0, (k / 5) as f64 / 4.0]).collect();
        let values: Vec<f64> = points.iter().map(|p| SQRT_2 * (5.0 * p[0]).cos()).collect();
        let process = GaussianProcess::fitted(&points, &values);
        assert!(process.lengths[1] > 4.0 * process.lengths[0], "{:?}", process.lengths);
    }
}
