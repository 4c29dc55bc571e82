//! Proportions with their intervals: Clopper-Pearson, which is exact, and Wilson, which is shorter.
//!
//! ```
//! // No false alarm in 150 trials: the exact one-sided 95 % limit is 1 - 0.05^(1/150).
//! let limit = stats::proportion::exact_upper(0, 150, 0.95)?;
//! assert!((limit - (1.0 - 0.05_f64.powf(1.0 / 150.0))).abs() < 1e-9);
//! # Ok::<(), stats::StatsError>(())
//! ```

use statrs::distribution::{Beta, ContinuousCDF, Normal};

use crate::Interval;
use crate::error::{StatsError, domain, open_unit};

/// Two-sided Clopper-Pearson interval of `count` successes in `of` trials (Biometrika 1934;26:404).
///
/// Covers the true proportion at least as often as `level` says. Without a trial it is 0 to 1.
///
/// # Errors
/// [`StatsError::OutOfDomain`] if `count` exceeds `of` or `level` lies outside (0, 1).
pub fn clopper_pearson(count: usize, of: usize, level: f64) -> Result<Interval, StatsError> {
    checked(count, of, level)?;
    let tail = 0.5 * (1.0 - level);
    let lower = if count == 0 { 0.0 } else { beta_quantile(count, of - count + 1, tail) };
    let upper = if count == of { 1.0 } else { beta_quantile(count + 1, of - count, 1.0 - tail) };
    Ok(Interval { lower, upper })
}

/// One-sided exact upper limit: the proportion lies below it with confidence `level`.
///
/// # Errors
/// As [`clopper_pearson`].
pub fn exact_upper(count: usize, of: usize, level: f64) -> Result<f64, StatsError> {
    checked(count, of, level)?;
    Ok(if count == of { 1.0 } else { beta_quantile(count + 1, of - count, level) })
}

/// Two-sided Wilson score interval (J Am Stat Assoc 1927;22:209). Without a trial it is 0 to 1.
///
/// # Errors
/// As [`clopper_pearson`].
pub fn wilson(count: usize, of: usize, level: f64) -> Result<Interval, StatsError> {
    checked(count, of, level)?;
    if of == 0 {
        return Ok(Interval { lower: 0.0, upper: 1.0 });
    }
    let z = Normal::standard().inverse_cdf(0.5 * (1.0 + level));
    let n = of as f64;
    let p = count as f64 / n;
    let scale = 1.0 / (1.0 + z * z / n);
    let centre = scale * (p + 0.5 * z * z / n);
    let half = scale * z * (p * (1.0 - p) / n + 0.25 * z * z / (n * n)).sqrt();
    // At 0 and at all successes an end equals 0 or 1 but for rounding.
    Ok(Interval { lower: (centre - half).max(0.0), upper: (centre + half).min(1.0) })
}

fn checked(count: usize, of: usize, level: f64) -> Result<(), StatsError> {
    open_unit("level", level)?;
    domain(count <= of, "count", count as f64, "at most the number of trials")
}

fn beta_quantile(a: usize, b: usize, p: f64) -> f64 {
    Beta::new(a as f64, b as f64).expect("both shapes are at least 1").inverse_cdf(p)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_agree_with_the_published_examples() {
        // Newcombe, Stat Med 1998;17:857, table I, methods 3 (Wilson) and 5 (Clopper-Pearson).
        for (count, of, wilson_ends, exact_ends) in [
            (81, 263, (0.2553, 0.3662), (0.2527, 0.3676)),
            (15, 148, (0.0624, 0.1605), (0.0578, 0.1617)),
            (0, 20, (0.0, 0.1611), (0.0, 0.1684)),
            (1, 29, (0.0061, 0.1718), (0.0009, 0.1776)),
        ] {
            for (found, published) in [
                (wilson(count, of, 0.95).expect("valid"), wilson_ends),
                (clopper_pearson(count, of, 0.95).expect("valid"), exact_ends),
            ] {
                // Four printed digits.
                assert!((found.lower - published.0).abs() < 6e-5, "{count}/{of}: {found:?}");
                assert!((found.upper - published.1).abs() < 6e-5, "{count}/{of}: {found:?}");
            }
        }
    }

    #[test]
    fn no_trial_says_nothing_and_all_or_none_reach_the_ends() {
        let everything = Interval { lower: 0.0, upper: 1.0 };
        assert_eq!(wilson(0, 0, 0.95).expect("valid"), everything);
        assert_eq!(clopper_pearson(0, 0, 0.95).expect("valid"), everything);
        assert_eq!(exact_upper(0, 0, 0.95).expect("valid"), 1.0);
        assert_eq!(clopper_pearson(7, 7, 0.95).expect("valid").upper, 1.0);
        assert_eq!(clopper_pearson(0, 7, 0.95).expect("valid").lower, 0.0);
    }

    #[test]
    fn the_one_sided_limit_is_an_end_of_the_two_sided_interval_at_twice_the_tail() {
        let one = exact_upper(6, 150, 0.95).expect("valid");
        let two = clopper_pearson(6, 150, 0.90).expect("valid").upper;
        assert!((one - two).abs() < 1e-12); // the same quantile but for rounding of the level
        assert!(one < 0.08 && exact_upper(7, 150, 0.95).expect("valid") > 0.08);
    }

    #[test]
    fn what_cannot_be_counted_is_refused() {
        assert!(wilson(3, 2, 0.95).is_err());
        assert!(clopper_pearson(1, 2, 1.0).is_err());
        assert!(exact_upper(1, 2, 0.0).is_err());
    }
}
