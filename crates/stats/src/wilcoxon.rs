//! Wilcoxon's signed-rank test for paired differences.

use statrs::distribution::{ContinuousCDF, Normal};

use crate::StatsError;
use crate::error::{at_least, finite};

/// Up to this number of differences the exact distribution is used (R's own limit is 50).
const EXACT_UP_TO: usize = 50;

/// How the p-value was computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Null {
    /// All sign patterns counted.
    Exact,
    /// Normal approximation with continuity and tie correction.
    Normal,
}

/// Result of the signed-rank test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignedRank {
    /// Differences that are not zero; zeros are left out, as Wilcoxon did.
    pub n: usize,
    /// Sum of the ranks of the positive differences.
    pub positive_ranks: f64,
    /// Two-sided p-value; 1 where every difference is zero.
    pub p: f64,
    /// How it was computed.
    pub null: Null,
}

/// Signed-rank test that paired `differences` are symmetric about zero.
///
/// Exact up to 50 differences without ties, else the normal approximation.
///
/// # Errors
///
/// [`StatsError::TooFew`] for no difference, [`StatsError::NonFinite`].
pub fn signed_rank(differences: &[f64]) -> Result<SignedRank, StatsError> {
    at_least(1, "differences", differences.len())?;
    finite("difference", differences)?;
    let mut kept: Vec<f64> = differences.iter().copied().filter(|d| *d != 0.0).collect();
    kept.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let n = kept.len();
    if n == 0 {
        return Ok(SignedRank { n, positive_ranks: 0.0, p: 1.0, null: Null::Exact });
    }

    let (mut positive_ranks, mut tie_term, mut ties) = (0.0, 0.0, n < differences.len());
    let mut start = 0;
    for group in kept.chunk_by(|a, b| a.abs() == b.abs()) {
        let size = group.len() as f64;
        let rank = start as f64 + (size + 1.0) / 2.0;
        positive_ranks += rank * group.iter().filter(|d| **d > 0.0).count() as f64;
        tie_term += size.powi(3) - size;
        ties |= group.len() > 1;
        start += group.len();
    }

    let count = n as f64;
    let total = count * (count + 1.0) / 2.0;
    if n <= EXACT_UP_TO && !ties {
        let smaller = positive_ranks.min(total - positive_ranks) as usize;
        return Ok(SignedRank { n, positive_ranks, p: exact(n, smaller), null: Null::Exact });
    }
    let variance = count * (count + 1.0) * (2.0 * count + 1.0) / 24.0 - tie_term / 48.0;
    let distance = ((positive_ranks - total / 2.0).abs() - 0.5).max(0.0);
    let p = (2.0 * Normal::standard().sf(distance / variance.sqrt())).min(1.0);
    Ok(SignedRank { n, positive_ranks, p, null: Null::Normal })
}

/// Two-sided p: twice the share of the 2^n sign patterns whose rank sum is at most `smaller`.
/// Counts up to 2^50 are exact in f64.
fn exact(n: usize, smaller: usize) -> f64 {
    let total = n * (n + 1) / 2;
    let mut patterns = vec![0.0; total + 1];
    patterns[0] = 1.0;
    for rank in 1..=n {
        for sum in (rank..=total).rev() {
            patterns[sum] += patterns[sum - rank];
        }
    }
    let reached: f64 = patterns[..=smaller].iter().sum();
    (2.0 * reached / (n as f64).exp2()).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_published_and_independent_values() {
        // Hollander and Wolfe (1973), depression scale of nine patients, the example of R's
        // `wilcox.test`: V = 40, two-sided exact p = 0.0390625 (one-sided 0.01953).
        let before = [1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30];
        #[expect(clippy::approx_constant, reason = "3.14 is a patient's score")]
        let after = [0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29];
        let differences: Vec<f64> = before.iter().zip(after).map(|(b, a)| b - a).collect();
        let test = signed_rank(&differences).expect("finite");
        assert_eq!((test.positive_ranks, test.null), (40.0, Null::Exact));
        assert!((test.p - 0.0390625).abs() < 1e-15, "a ratio of integers: {}", test.p);
    }

    #[test]
    fn ties_and_zeros_use_the_corrected_normal() {
        // scipy 1.17.1: stats.wilcoxon(x, method='approx', correction=True), zeros dropped.
        let x = [1., -2., 2., 2., 3., -1., 4., 5., 0., 6., 7., -3., 2., 8., 9.];
        let test = signed_rank(&x).expect("finite");
        assert_eq!((test.n, test.null), (14, Null::Normal));
        // 1e-10: the two normal tails are computed by different series.
        assert!((test.p - 0.015347650325917556).abs() < 1e-10, "{}", test.p);
    }

    #[test]
    fn degenerate_input_is_defined() {
        assert_eq!(signed_rank(&[0.0, 0.0]).expect("finite").p, 1.0);
        assert_eq!(signed_rank(&[2.0]).expect("finite").p, 1.0);
        assert!(signed_rank(&[]).is_err());
        assert!(signed_rank(&[f64::NAN]).is_err());
    }
}
