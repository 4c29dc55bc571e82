//! Prewhitening of normalised innovations by a fitted AR(2), and Huber weights.
//!
//! A filter whose noise model is not quite a person's leaves innovations that are correlated from
//! one step to the next. An autoregression of order two takes that out before innovations are
//! averaged or used to calibrate, and Huber's weights keep single wild readings from deciding.

/// An autoregression of order two over entries `spacing` steps apart,
/// z_k = a1 z_(k-s) + a2 z_(k-2s) + w_k.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Autoregression {
    /// Coefficient of the entry before.
    pub a1: f64,
    /// Coefficient of the entry before that.
    pub a2: f64,
    /// Steps between entries: 1 for a sensor that reads every five minutes, 3 for every fifteen.
    pub spacing: usize,
}

/// Huber's threshold in standard deviations: 2.5 keeps 98 % of the efficiency on Gaussian noise.
pub const HUBER_THRESHOLD: f64 = 2.5;
/// Median absolute deviation to standard deviation for a Gaussian: 1 / 0.6745.
const MAD_TO_SD: f64 = 1.4826;

impl Autoregression {
    /// No correlation: whitening with it changes nothing.
    pub const WHITE: Self = Self { a1: 0.0, a2: 0.0, spacing: 1 };

    /// Fits by the Yule-Walker equations.
    ///
    /// `z` one entry a step; `None` (a missing or unscored step) contributes nothing. The spacing is
    /// the distance between entries that covers most of the time. Lagged products are summed over the pairs that exist,
    /// which is the autocovariance of the series with zeros in its gaps; the fit is therefore always
    /// stationary. Coefficients are zero where fewer than ten entries exist or all are zero.
    #[must_use]
    pub fn fitted(z: &[Option<f64>]) -> Self {
        let white = Self { spacing: commonest_spacing(z), ..Self::WHITE };
        if z.iter().flatten().count() < 10 {
            return white;
        }
        let r0 = lagged_product(z, 0);
        let (r1, r2) = (lagged_product(z, white.spacing), lagged_product(z, 2 * white.spacing));
        let determinant = r0 * r0 - r1 * r1;
        if determinant <= f64::EPSILON * r0 * r0 {
            return white;
        }
        let (a1, a2) = (r1 * (r0 - r2) / determinant, (r0 * r2 - r1 * r1) / determinant);
        Self { a1, a2, ..white }
    }

    /// The series with its predictable part removed; `None` where one of the three entries needed
    /// is missing.
    #[must_use]
    pub fn whitened(&self, z: &[Option<f64>]) -> Vec<Option<f64>> {
        (0..z.len()).map(|k| self.whitened_at(z, k)).collect()
    }

    /// What is left of an entry, given the two before it.
    pub(crate) fn left(&self, now: f64, before: f64, earlier: f64) -> f64 {
        now - self.a1 * before - self.a2 * earlier
    }

    /// One entry of [`whitened`](Self::whitened).
    pub(crate) fn whitened_at(&self, z: &[Option<f64>], k: usize) -> Option<f64> {
        let earlier =
            |entries: usize| k.checked_sub(entries * self.spacing).and_then(|earlier| z[earlier]);
        Some(self.left(z[k]?, earlier(1)?, earlier(2)?))
    }
}

/// The distance between successive entries that covers most of the time, at most an hour; 1 where there are none. Of a
/// person who wore a sensor that reads every fifteen minutes for ten days, and then one that reads every five for four,
/// this keeps all days: whoever reads every five minutes reads every fifteen.
fn commonest_spacing(z: &[Option<f64>]) -> usize {
    let mut counts = [0usize; 13];
    let entries = || (0..z.len()).filter(move |k| z[*k].is_some());
    for (earlier, later) in entries().zip(entries().skip(1)) {
        if let Some(count) = counts.get_mut(later - earlier) {
            *count += 1;
        }
    }
    (1..counts.len()).rev().max_by_key(|distance| distance * counts[*distance]).unwrap_or(1)
}

fn lagged_product(z: &[Option<f64>], lag: usize) -> f64 {
    z.iter().zip(&z[lag.min(z.len())..]).filter_map(|(a, b)| Some((*a)? * (*b)?)).sum()
}

/// Robust scale of a series: 1.4826 times the median absolute value; 0 for an empty one.
#[must_use]
pub fn robust_scale(w: &[Option<f64>]) -> f64 {
    let mut sizes: Vec<f64> = w.iter().flatten().map(|v| v.abs()).collect();
    MAD_TO_SD * median(&mut sizes)
}

/// The median; 0 for no value.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Huber's weight of a residual `value` when the scale is `scale`: 1 within
/// [`HUBER_THRESHOLD`] scales, falling as 1/|value| beyond.
#[must_use]
pub fn huber_weight(value: f64, scale: f64) -> f64 {
    let limit = HUBER_THRESHOLD * scale;
    if value.abs() <= limit { 1.0 } else { limit / value.abs() }
}

/// Huber's loss of a residual: half its square within [`HUBER_THRESHOLD`] scales, linear beyond.
#[must_use]
pub fn huber_loss(value: f64, scale: f64) -> f64 {
    let limit = HUBER_THRESHOLD * scale;
    if value.abs() <= limit { 0.5 * value * value } else { limit * (value.abs() - 0.5 * limit) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Uniform noise of variance 1: enough for second moments.
    fn noise(rng: &mut ChaCha8Rng) -> f64 {
        rng.random_range(-1.0..1.0) * 3f64.sqrt()
    }

    fn autoregressive(a1: f64, a2: f64, n: usize) -> Vec<Option<f64>> {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (mut before, mut earlier) = (0.0, 0.0);
        (0..n)
            .map(|_| {
                let z = a1 * before + a2 * earlier + noise(&mut rng);
                (earlier, before) = (before, z);
                Some(z)
            })
            .collect()
    }

    #[test]
    fn the_fit_recovers_the_coefficients_and_leaves_white_noise() {
        let z = autoregressive(0.9, -0.3, 20_000);
        let fit = Autoregression::fitted(&z);
        // Standard error of an AR coefficient is about sqrt((1 - a2^2)/n) = 0.0067; five of them.
        assert!((fit.a1 - 0.9).abs() < 0.034 && (fit.a2 + 0.3).abs() < 0.034, "{fit:?}");
        let w = fit.whitened(&z);
        let correlation = lagged_product(&w, 1) / lagged_product(&w, 0);
        assert!(correlation.abs() < 5.0 / 20_000f64.sqrt(), "lag-1 correlation {correlation}");
        assert_eq!(w[..2], [None, None]);
    }

    #[test]
    fn a_gap_costs_the_entries_that_need_it_and_no_others() {
        let mut z = autoregressive(0.5, 0.1, 100);
        z[50] = None;
        let w = Autoregression { a1: 0.5, a2: 0.1, spacing: 1 }.whitened(&z);
        assert!(w[50..53].iter().all(Option::is_none));
        assert!(w[49].is_some() && w[53].is_some());
    }

    #[test]
    fn a_sensor_that_reads_every_fifteen_minutes_is_whitened_over_its_readings() {
        let dense = autoregressive(0.6, 0.2, 6_000);
        let mut z = vec![None; 3 * dense.len()];
        for (k, value) in dense.iter().enumerate() {
            z[3 * k + 1] = *value;
        }
        let fit = Autoregression::fitted(&z);
        assert_eq!(fit.spacing, 3);
        let direct = Autoregression::fitted(&dense);
        assert_eq!((fit.a1, fit.a2), (direct.a1, direct.a2));
        let whitened: Vec<f64> = fit.whitened(&z).into_iter().flatten().collect();
        let directly: Vec<f64> = direct.whitened(&dense).into_iter().flatten().collect();
        assert_eq!(whitened, directly);
        assert_eq!(Autoregression::fitted(&[None, None]).spacing, 1);
    }

    #[test]
    fn where_sensors_change_from_fifteen_minutes_to_five_no_day_is_lost() {
        let z: Vec<Option<f64>> = autoregressive(0.6, 0.2, 14 * 288)
            .into_iter()
            .enumerate()
            .map(|(k, value)| value.filter(|_| k % 3 == 0 || k >= 10 * 288))
            .collect();
        let fit = Autoregression::fitted(&z);
        // Lost: two at the start, and four whose minutes have no reading before the change.
        let left = fit.whitened(&z).iter().flatten().count();
        assert_eq!((fit.spacing, left), (3, z.iter().flatten().count() - 6));
    }

    #[test]
    fn the_fit_is_stationary_even_for_a_ramp() {
        let z: Vec<_> = (0..200).map(|k| Some(f64::from(k))).collect();
        let fit = Autoregression::fitted(&z);
        assert!(fit.a2.abs() < 1.0 && fit.a1.abs() < 1.0 - fit.a2, "{fit:?}");
    }

    #[test]
    fn huber_agrees_with_least_squares_inside_and_is_bounded_outside() {
        assert_eq!(huber_weight(2.0, 1.0), 1.0);
        assert_eq!(huber_weight(-5.0, 1.0), 0.5);
        assert_eq!(huber_loss(2.0, 1.0), 2.0);
        // Continuous at the threshold: 2.5^2 / 2 from both sides, to rounding.
        assert!((huber_loss(2.5, 1.0) - huber_loss(2.5 + 1e-12, 1.0)).abs() < 1e-11);
        let w: Vec<_> = [-1.0, 1.0, 0.5, -0.5, 9.0].map(Some).into();
        assert!((robust_scale(&w) - MAD_TO_SD).abs() < 1e-15);
        assert_eq!(robust_scale(&[None]), 0.0);
    }
}
