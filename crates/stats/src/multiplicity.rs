//! Adjustment for asking several questions: Holm, Benjamini-Hochberg, and max-T step-down.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::bootstrap::ReplicateMatrix;
use crate::error::open_unit;
use crate::moments::mean_and_sd;
use crate::{Interval, StatsError};

/// Holm (1979) adjusted p-values, in the order given; controls the family-wise error under any
/// dependence.
///
/// # Errors
///
/// [`StatsError::OutOfDomain`] for a p-value below 0, above 1 or NaN.
pub fn holm(p: &[f64]) -> Result<Vec<f64>, StatsError> {
    let ascending = ranked(p)?;
    let mut adjusted = vec![0.0; p.len()];
    let mut so_far: f64 = 0.0;
    for (rank, index) in ascending.into_iter().enumerate() {
        so_far = so_far.max((p.len() - rank) as f64 * p[index]).min(1.0);
        adjusted[index] = so_far;
    }
    Ok(adjusted)
}

/// Benjamini and Hochberg (1995) adjusted p-values, in the order given; controls the false
/// discovery rate under independence or positive regression dependence.
///
/// # Errors
///
/// [`StatsError::OutOfDomain`] for a p-value below 0, above 1 or NaN.
pub fn benjamini_hochberg(p: &[f64]) -> Result<Vec<f64>, StatsError> {
    let ascending = ranked(p)?;
    let mut adjusted = vec![0.0; p.len()];
    let mut so_far: f64 = 1.0;
    for (rank, index) in ascending.into_iter().enumerate().rev() {
        so_far = so_far.min(p.len() as f64 / (rank + 1) as f64 * p[index]);
        adjusted[index] = so_far;
    }
    Ok(adjusted)
}

/// Indices by ascending p, the earlier first among equals.
fn ranked(p: &[f64]) -> Result<Vec<usize>, StatsError> {
    if let Some(value) = p.iter().find(|p| !(0.0..=1.0).contains(*p)) {
        let expected = "a p-value between 0 and 1";
        return Err(StatsError::OutOfDomain { name: "p", value: *value, expected });
    }
    let mut ascending: Vec<usize> = (0..p.len()).collect();
    ascending.sort_by(|a, b| p[*a].total_cmp(&p[*b]));
    Ok(ascending)
}

/// One statistic of a family tested against zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaxTRow {
    /// The statistic on the full sample.
    pub value: f64,
    /// Its bootstrap standard error, times `sqrt(n / (n - 1))` for `n` people.
    pub standard_error: f64,
    /// `value / standard_error`.
    pub t: f64,
    /// Two-sided p-value, adjusted for the family by the step-down max-T.
    pub p_adjusted: f64,
    /// Simultaneous interval: all intervals of the family cover together at the level.
    pub interval: Interval,
}

/// A family of statistics tested jointly against zero.
#[derive(Debug, Clone, PartialEq)]
pub struct MaxT {
    /// Quantile of the maximum |t| with the small-sample correction; the intervals are value +- critical x standard error.
    pub critical: f64,
    /// Joint coverage of the intervals.
    pub level: f64,
    /// One row a statistic, in the order of the matrix.
    pub rows: Vec<MaxTRow>,
}

/// Step-down max-T of Westfall and Young (1993), with simultaneous intervals.
///
/// The null distribution of `t_j` is taken from replicates centred at their estimate,
/// `t*_j = (theta*_j - theta_j) / se_j`, drawn jointly so that the dependence between statistics is
/// kept. In the order of falling |t|, the adjusted p of a statistic is the share of replicates
/// (counting the sample itself) whose maximum |t*| over it and all weaker ones reaches |t|, made
/// monotone. The intervals are single-step (the quantile of the maximum over all).
///
/// With few people the bootstrap is too narrow: its spread divides by n, and the replicates know
/// nothing of the error in their own SE. As Hesterberg (2015) expands percentile intervals, SEs
/// are multiplied by `sqrt(n / (n - 1))` and normal quantiles are replaced by those of Student's
/// t with n - 1 degrees of freedom, where the matrix knows its n people.
///
/// # Errors
///
/// [`StatsError::OutOfDomain`] for a level outside (0, 1), [`StatsError::ConstantReplicates`] for
/// a statistic without spread.
pub fn max_t(matrix: &ReplicateMatrix, level: f64) -> Result<MaxT, StatsError> {
    open_unit("level", level)?;
    let small = SmallSample::of(matrix.people());
    let estimates = matrix.estimates();
    let spreads: Vec<f64> = (0..estimates.len())
        .map(|column| {
            let values: Vec<f64> = matrix.rows().iter().map(|row| row[column]).collect();
            let (_, sd) = mean_and_sd(&values);
            if sd > 0.0 { Ok(sd) } else { Err(StatsError::ConstantReplicates { column }) }
        })
        .collect::<Result<_, _>>()?;
    let errors: Vec<f64> = spreads.iter().map(|sd| sd * small.spread).collect();
    let t: Vec<f64> = estimates.iter().zip(&errors).map(|(value, se)| value / se).collect();
    let thresholds: Vec<f64> = t.iter().map(|t| small.normal_equivalent(t.abs())).collect();
    let mut falling: Vec<usize> = (0..t.len()).collect();
    falling.sort_by(|a, b| t[*b].abs().total_cmp(&t[*a].abs()));

    let mut reached = vec![1_usize; t.len()];
    let mut maxima = Vec::with_capacity(matrix.rows().len());
    for row in matrix.rows() {
        let mut maximum: f64 = 0.0;
        for column in falling.iter().rev().copied() {
            maximum = maximum.max(((row[column] - estimates[column]) / spreads[column]).abs());
            if maximum >= thresholds[column] {
                reached[column] += 1;
            }
        }
        maxima.push(maximum);
    }
    let mut p_adjusted = vec![0.0; t.len()];
    let mut so_far: f64 = 0.0;
    for column in falling {
        so_far = so_far.max(reached[column] as f64 / (maxima.len() + 1) as f64);
        p_adjusted[column] = so_far;
    }

    maxima.sort_by(f64::total_cmp);
    let rank = (level * (maxima.len() + 1) as f64).ceil() as usize;
    let critical = small.student_equivalent(maxima[rank.min(maxima.len()) - 1]);
    let rows = (0..t.len())
        .map(|j| MaxTRow {
            value: estimates[j],
            standard_error: errors[j],
            t: t[j],
            p_adjusted: p_adjusted[j],
            interval: Interval {
                lower: estimates[j] - critical * errors[j],
                upper: estimates[j] + critical * errors[j],
            },
        })
        .collect();
    Ok(MaxT { critical, level, rows })
}

/// Small-sample correction of a bootstrap over `n` people.
struct SmallSample {
    /// Factor on the standard errors.
    spread: f64,
    /// Student's t with n - 1 degrees of freedom; `None` where the people are not known.
    student: Option<StudentsT>,
}

impl SmallSample {
    fn of(people: Option<usize>) -> Self {
        let degrees = people.map_or(0.0, |n| n as f64 - 1.0);
        match StudentsT::new(0.0, 1.0, degrees) {
            Ok(student) if degrees > 0.0 => {
                Self { spread: ((degrees + 1.0) / degrees).sqrt(), student: Some(student) }
            }
            _ => Self { spread: 1.0, student: None },
        }
    }

    /// The normal quantile with the same tail as Student's `t`, at least 0; infinite where the
    /// tail vanishes.
    fn normal_equivalent(&self, t: f64) -> f64 {
        match &self.student {
            Some(student) => -Normal::standard().inverse_cdf(student.sf(t)),
            None => t,
        }
    }

    /// The quantile of Student's t with the same tail as the normal `z`, at least 0.
    fn student_equivalent(&self, z: f64) -> f64 {
        match &self.student {
            Some(student) => -student.inverse_cdf(Normal::standard().sf(z)),
            None => z,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_correction_inverts_and_vanishes_for_many_people() {
        let few = SmallSample::of(Some(10));
        // Student's t at 9 degrees of freedom, 97.5 %: 2.262157 (any table), normal 1.959964.
        assert!((few.student_equivalent(1.959963984540054) - 2.262157162798205).abs() < 1e-6);
        assert!((few.normal_equivalent(2.262157162798205) - 1.959963984540054).abs() < 1e-6);
        let many = SmallSample::of(Some(1_000_000));
        // The expansion of t in 1/n differs from z by (z + z^3) / 4n, 3e-6 here.
        assert!((many.normal_equivalent(2.0) - 2.0).abs() < 1e-5);
        assert_eq!(SmallSample::of(None).normal_equivalent(2.0), 2.0);
        assert!(few.normal_equivalent(1e300) > 30.0, "a vanishing tail stays out of reach");
    }

    #[test]
    fn people_widen_intervals_and_raise_p() {
        let rows: Vec<Vec<f64>> = (0..199).map(|k| vec![f64::from(k % 20) / 10.0]).collect();
        let family = |left_out: Vec<Vec<f64>>| {
            let matrix = ReplicateMatrix::new(vec![0.95], rows.clone(), left_out);
            max_t(&matrix.expect("valid"), 0.9).expect("varies")
        };
        let (known, unknown) = (family(vec![vec![0.9]; 4]), family(vec![]));
        let ratio = known.rows[0].standard_error / unknown.rows[0].standard_error;
        // n / (n - 1) for four people, under the root.
        assert!((ratio - (4.0_f64 / 3.0).sqrt()).abs() < 1e-14, "{ratio}");
        assert!(known.critical > unknown.critical);
        assert!(known.rows[0].p_adjusted > unknown.rows[0].p_adjusted);
    }
}
