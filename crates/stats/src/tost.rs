//! Paired two one-sided t-tests (TOST) for equivalence.
//!
//! Schuirmann (1987). With mean difference `d`, its standard error `se` and margin `m`,
//! `t_lower = (d + m) / se` tests "not below -m" and `t_upper = (d - m) / se` "not above m"; the
//! larger of the two one-sided p-values is reported, and equivalence at level alpha is the same as
//! the (1 - 2 alpha) interval lying inside the margin.

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::error::{at_least, domain, open_unit, pairs};
use crate::moments::mean_and_sd;
use crate::{Interval, StatsError};

/// Result of a paired TOST.
///
/// The t values are infinite where the differences do not vary; JSON writes them as null.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tost {
    /// Number of pairs.
    pub n: usize,
    /// Mean of simulated minus actual, in the outcome's unit.
    pub difference: f64,
    /// Sample SD of the paired differences, in the outcome's unit.
    pub sd: f64,
    /// Equivalence margin, in the outcome's unit.
    pub margin: f64,
    /// Level of each one-sided test.
    pub alpha: f64,
    /// t of the test against the lower margin; large and positive speaks for equivalence.
    pub t_lower: f64,
    /// t of the test against the upper margin; large and negative speaks for equivalence.
    pub t_upper: f64,
    /// The larger of the two one-sided p-values.
    pub p: f64,
    /// Interval of level 1 - 2 alpha for the mean difference (90 % at alpha = 0.05).
    pub interval: Interval,
    /// Whether `p < alpha`.
    pub equivalent: bool,
}

/// Paired TOST of `simulated` against `actual`, one value a person in the same order.
///
/// Where all differences are the same, the tests are at their limit: p = 0 inside the margin, 1
/// outside and 0.5 exactly on it, and the interval is a point.
///
/// # Errors
///
/// [`StatsError::Unpaired`], [`StatsError::TooFew`] below two pairs, [`StatsError::NonFinite`],
/// and [`StatsError::OutOfDomain`] as for [`from_summary`].
pub fn paired(
    actual: &[f64],
    simulated: &[f64],
    margin: f64,
    alpha: f64,
) -> Result<Tost, StatsError> {
    pairs(("actual", actual), ("simulated", simulated))?;
    let differences: Vec<f64> = simulated.iter().zip(actual).map(|(s, a)| s - a).collect();
    let (difference, sd) = mean_and_sd(&differences);
    from_summary(differences.len(), difference, sd, margin, alpha)
}

/// TOST from the number of pairs and the mean and SD of their differences, as printed in papers.
///
/// # Errors
///
/// [`StatsError::TooFew`] below two pairs; [`StatsError::OutOfDomain`] unless the difference is
/// finite, `sd >= 0`, `margin > 0` and `0 < alpha < 0.5`.
pub fn from_summary(
    n: usize,
    difference: f64,
    sd: f64,
    margin: f64,
    alpha: f64,
) -> Result<Tost, StatsError> {
    at_least(2, "pairs", n)?;
    domain(difference.is_finite(), "difference", difference, "a finite number")?;
    domain(sd.is_finite() && sd >= 0.0, "sd", sd, "a finite number, not negative")?;
    domain(margin.is_finite() && margin > 0.0, "margin", margin, "a positive number")?;
    open_unit("alpha", alpha)?;
    domain(alpha < 0.5, "alpha", alpha, "a level below 0.5")?;

    let degrees = (n - 1) as f64;
    let student = StudentsT::new(0.0, 1.0, degrees).expect("n >= 2 leaves a degree of freedom");
    let se = sd / (n as f64).sqrt();
    let t = |distance: f64| match (se > 0.0, distance == 0.0) {
        (true, _) => distance / se,
        (false, true) => 0.0,
        (false, false) => distance.signum() * f64::INFINITY,
    };
    let t_lower = t(difference + margin);
    let t_upper = t(difference - margin);
    let p = student.sf(t_lower).max(student.sf(-t_upper));
    let half_width = se * student.inverse_cdf(1.0 - alpha);

    Ok(Tost {
        n,
        difference,
        sd,
        margin,
        alpha,
        t_lower,
        t_upper,
        p,
        interval: Interval { lower: difference - half_width, upper: difference + half_width },
        equivalent: p < alpha,
    })
}
