//! Replicates of several statistics, and the intervals that they give.

use statrs::distribution::{ContinuousCDF, Normal};

use crate::error::{at_least, finite, open_unit};
use crate::moments::{mean, mean_and_sd};
use crate::quantile::quantile;
use crate::{Estimate, Interval, StatsError};

/// Bootstrap replicates, `(replicates, statistics)`, with the values on the full sample and with
/// each person left out.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplicateMatrix {
    estimates: Vec<f64>,
    rows: Vec<Vec<f64>>,
    left_out: Vec<Vec<f64>>,
}

impl ReplicateMatrix {
    /// Puts together `estimates` (a value a statistic), `rows` (replicates by statistics) and
    /// `left_out` (people by statistics; may be empty, then there are no BCa intervals).
    ///
    /// # Errors
    ///
    /// [`StatsError::TooFew`] below two replicates, [`StatsError::NonFinite`] for an estimate,
    /// [`StatsError::RaggedReplicate`] and [`StatsError::UndefinedReplicate`] for a replicate.
    pub fn new(
        estimates: Vec<f64>,
        rows: Vec<Vec<f64>>,
        left_out: Vec<Vec<f64>>,
    ) -> Result<Self, StatsError> {
        finite("statistic", &estimates)?;
        at_least(2, "replicates", rows.len())?;
        for (replicate, row) in rows.iter().enumerate() {
            if row.len() != estimates.len() {
                let (found, expected) = (row.len(), estimates.len());
                return Err(StatsError::RaggedReplicate { replicate, found, expected });
            }
            if let Some(column) = row.iter().position(|v| !v.is_finite()) {
                let value = row[column];
                return Err(StatsError::UndefinedReplicate { replicate, column, value });
            }
        }
        if let Some(row) = left_out.iter().find(|row| row.len() != estimates.len()) {
            let (found, expected) = (row.len(), estimates.len());
            return Err(StatsError::RaggedReplicate { replicate: 0, found, expected });
        }
        Ok(Self { estimates, rows, left_out })
    }

    /// The statistics on the full sample.
    #[must_use]
    pub fn estimates(&self) -> &[f64] {
        &self.estimates
    }

    /// One statistic with its intervals at `level`.
    ///
    /// # Errors
    ///
    /// [`StatsError::OutOfDomain`] where there is no such statistic, or for a level outside (0, 1).
    pub fn estimate(&self, statistic: usize, level: f64) -> Result<Estimate, StatsError> {
        open_unit("level", level)?;
        let Some(&value) = self.estimates.get(statistic) else {
            let expected = "an index below the number of statistics";
            let (name, value) = ("statistic", statistic as f64);
            return Err(StatsError::OutOfDomain { name, value, expected });
        };
        let mut sorted: Vec<f64> = self.rows.iter().map(|row| row[statistic]).collect();
        let (_, standard_error) = mean_and_sd(&sorted);
        sorted.sort_by(f64::total_cmp);
        let tails = [(1.0 - level) / 2.0, (1.0 + level) / 2.0];
        Ok(Estimate {
            value,
            standard_error,
            percentile: Interval {
                lower: quantile(&sorted, tails[0]),
                upper: quantile(&sorted, tails[1]),
            },
            bca: self.bca(statistic, &sorted, tails),
            level,
            replicates: self.rows.len(),
        })
    }

    /// Bias-corrected and accelerated interval, Efron (1987), eqs. 6.6-6.8 of Davison and Hinkley
    /// in other symbols: `a = sum d^3 / (6 (sum d^2)^1.5)` with `d` the jackknife deviations,
    /// `z0` the normal quantile of the share of replicates below the estimate (ties count half).
    fn bca(&self, statistic: usize, sorted: &[f64], tails: [f64; 2]) -> Option<Interval> {
        let value = self.estimates[statistic];
        if sorted.first() == sorted.last() {
            return Some(Interval { lower: sorted[0], upper: sorted[0] });
        }
        let below = sorted.partition_point(|v| *v < value);
        let not_above = sorted.partition_point(|v| *v <= value);
        let share = (below + not_above) as f64 / (2 * sorted.len()) as f64;
        let left_out: Vec<f64> = self.left_out.iter().map(|row| row[statistic]).collect();
        let defined = !left_out.is_empty() && left_out.iter().all(|v| v.is_finite());
        if share <= 0.0 || share >= 1.0 || !defined {
            return None;
        }

        let centre = mean(&left_out);
        let (squares, cubes) = left_out.iter().fold((0.0, 0.0), |(s, c), v| {
            let d: f64 = centre - v;
            (s + d * d, c + d * d * d)
        });
        let acceleration = if squares > 0.0 { cubes / (6.0 * squares.powf(1.5)) } else { 0.0 };
        let normal = Normal::standard();
        let z0 = normal.inverse_cdf(share);
        let [lower, upper] = tails.map(|tail| {
            let z = z0 + normal.inverse_cdf(tail);
            quantile(sorted, normal.cdf(z0 + z / (1.0 - acceleration * z)))
        });
        Some(Interval { lower, upper })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_used_is_named() {
        let undefined = ReplicateMatrix::new(vec![1.0], vec![vec![1.0], vec![f64::NAN]], vec![]);
        assert!(matches!(
            undefined,
            Err(StatsError::UndefinedReplicate { replicate: 1, column: 0, .. })
        ));
        let ragged = ReplicateMatrix::new(vec![1.0], vec![vec![1.0], vec![]], vec![]);
        assert!(matches!(ragged, Err(StatsError::RaggedReplicate { replicate: 1, .. })));
        let single = ReplicateMatrix::new(vec![1.0], vec![vec![1.0]], vec![]);
        assert!(matches!(single, Err(StatsError::TooFew { .. })));
        let sound = ReplicateMatrix::new(vec![1.0], vec![vec![1.0], vec![2.0]], vec![]);
        assert!(sound.expect("two replicates").estimate(1, 0.9).is_err());
    }

    #[test]
    fn bca_is_absent_where_it_is_undefined() {
        let one_sided =
            ReplicateMatrix::new(vec![0.0], vec![vec![1.0], vec![2.0]], vec![vec![0.0], vec![1.0]]);
        assert_eq!(one_sided.expect("valid").estimate(0, 0.9).expect("valid").bca, None);
    }

    #[test]
    fn a_symmetric_case_agrees_with_the_percentiles() {
        let rows: Vec<Vec<f64>> = (-500..=500).map(|k| vec![f64::from(k)]).collect();
        let matrix = ReplicateMatrix::new(vec![0.0], rows, vec![vec![-1.0], vec![1.0]]);
        let estimate = matrix.expect("valid").estimate(0, 0.9).expect("valid");
        let bca = estimate.bca.expect("replicates on both sides");
        // No bias and no acceleration: only the normal quantile's rounding remains.
        assert!((bca.lower - estimate.percentile.lower).abs() < 1e-6);
        assert!((bca.upper - estimate.percentile.upper).abs() < 1e-6);
        assert!((estimate.percentile.upper - 450.0).abs() < 1e-9);
    }
}
