//! Comparison of two methods over the same people.

use contract::Summary;

use crate::error::pairs;
use crate::moments::mean;
use crate::wilcoxon::{SignedRank, signed_rank};
use crate::{Bootstrap, Estimate, StatsError, summary};

/// How one method compares with another, a figure (say RMSE) a person for both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairedComparison {
    /// Mean and SD over people of the first method.
    pub first: Summary,
    /// Mean and SD over people of the second method.
    pub second: Summary,
    /// Mean of first minus second, with bootstrap intervals over people.
    pub difference: Estimate,
    /// Signed-rank test of the differences.
    pub signed_rank: SignedRank,
}

/// Compares `first` with `second`, one value a person in the same order.
///
/// # Errors
///
/// [`StatsError::Unpaired`], [`StatsError::TooFew`] below two people, [`StatsError::NonFinite`],
/// and those of [`Bootstrap::people`].
pub fn compare(
    first: &[f64],
    second: &[f64],
    plan: &Bootstrap,
) -> Result<PairedComparison, StatsError> {
    pairs(("first", first), ("second", second))?;
    let differences: Vec<f64> = first.iter().zip(second).map(|(f, s)| f - s).collect();
    let difference = plan
        .people(&differences, |people| mean(&people.iter().map(|d| **d).collect::<Vec<f64>>()))?;
    Ok(PairedComparison {
        first: summary(first)?,
        second: summary(second)?,
        difference,
        signed_rank: signed_rank(&differences)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: Bootstrap = Bootstrap { replicates: 4000, level: 0.95, seed: 11 };

    #[test]
    fn pairing_removes_what_people_share() {
        // People differ by tens, the methods by about two: unpaired, nothing would show.
        let twin: Vec<f64> = (0..20).map(|k| 20.0 + 3.0 * f64::from(k)).collect();
        let ode: Vec<f64> =
            twin.iter().enumerate().map(|(k, v)| v + 2.0 + 0.1 * (k % 5) as f64).collect();
        let result = compare(&twin, &ode, &PLAN).expect("valid");
        assert!((result.difference.value + 2.2).abs() < 1e-12, "mean of 2, 2.1, ..., 2.4");
        assert!(result.difference.percentile.upper < -2.1);
        assert!(result.signed_rank.p < 1e-3);
        assert!(result.first.sd.expect("20 people") > 10.0);
    }

    #[test]
    fn methods_that_agree_give_a_point() {
        let same = compare(&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0], &PLAN).expect("valid");
        assert_eq!(same.difference.percentile.lower, 0.0);
        assert_eq!(same.difference.percentile.upper, 0.0);
        assert_eq!(same.signed_rank.p, 1.0);
    }
}
