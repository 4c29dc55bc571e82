//! Quantiles by linear interpolation.

use crate::StatsError;
use crate::error::{at_least, finite};

/// Quantiles of values in any order (type 7 of Hyndman and Fan, Am Stat 1996;50:361); `levels` from 0
/// to 1, in the unit of the values.
///
/// # Errors
/// [`StatsError::TooFew`] for no value, [`StatsError::NonFinite`] for a NaN or an infinity.
pub fn quantiles<const N: usize>(values: &[f64], levels: [f64; N]) -> Result<[f64; N], StatsError> {
    at_least(1, "values", values.len())?;
    finite("value", values)?;
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    Ok(levels.map(|level| quantile(&sorted, level)))
}

/// Quantile of sorted values, of which there is at least one, by linear interpolation (type 7 of Hyndman and
/// Fan 1996).
#[must_use]
pub fn quantile(sorted: &[f64], p: f64) -> f64 {
    let position = p.clamp(0.0, 1.0) * (sorted.len() - 1) as f64;
    let low = position.floor() as usize;
    let high = (low + 1).min(sorted.len() - 1);
    sorted[low] + (position - low as f64) * (sorted[high] - sorted[low])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate() {
        // numpy.quantile([1, 2, 4, 8], [0, 0.1, 0.5, 0.9, 1])
        let sorted = [1.0, 2.0, 4.0, 8.0];
        for (p, numpy) in [(0.0, 1.0), (0.1, 1.3), (0.5, 3.0), (0.9, 6.8), (1.0, 8.0)] {
            assert!((quantile(&sorted, p) - numpy).abs() < 1e-14, "{p}");
            let [found] = quantiles(&[8.0, 1.0, 4.0, 2.0], [p]).expect("finite");
            assert!((found - numpy).abs() < 1e-14, "{p}");
        }
        assert!(quantiles(&[], [0.5]).is_err() && quantiles(&[f64::NAN], [0.5]).is_err());
    }
}
