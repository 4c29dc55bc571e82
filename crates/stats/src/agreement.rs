//! Error of a simulated trace against its reference.

use crate::StatsError;
use crate::error::{at_least, finite};

/// Errors of one person's simulated values against the reference, in the unit of the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    /// Number of compared samples.
    pub n: usize,
    /// Root mean squared error.
    pub rmse: f64,
    /// Mean absolute error.
    pub mae: f64,
    /// Mean of simulated minus reference.
    pub bias: f64,
}

/// RMSE, MAE and bias of `simulated` against `reference`, sample by sample; samples that are
/// missing in either are left out by the caller.
///
/// # Errors
///
/// [`StatsError::Unpaired`], [`StatsError::TooFew`] for no sample, [`StatsError::NonFinite`].
pub fn agreement(reference: &[f64], simulated: &[f64]) -> Result<Agreement, StatsError> {
    if reference.len() != simulated.len() {
        return Err(StatsError::Unpaired { left: reference.len(), right: simulated.len() });
    }
    at_least(1, "samples", reference.len())?;
    finite("reference", reference)?;
    finite("simulated", simulated)?;
    let n = reference.len() as f64;
    let (mut squares, mut absolutes, mut sum) = (0.0, 0.0, 0.0);
    for (r, s) in reference.iter().zip(simulated) {
        let error = s - r;
        squares += error * error;
        absolutes += error.abs();
        sum += error;
    }
    Ok(Agreement {
        n: reference.len(),
        rmse: (squares / n).sqrt(),
        mae: absolutes / n,
        bias: sum / n,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_a_small_trace() {
        let person = agreement(&[100.0, 110.0, 120.0], &[103.0, 106.0, 120.0]).expect("valid");
        assert_eq!(person.n, 3);
        // sqrt(25/3), 7/3, -1/3 to rounding.
        assert!((person.rmse - (25.0_f64 / 3.0).sqrt()).abs() < 1e-14);
        assert!((person.mae - 7.0 / 3.0).abs() < 1e-14);
        assert!((person.bias + 1.0 / 3.0).abs() < 1e-14);
    }

    #[test]
    fn bad_input_is_named() {
        assert!(matches!(agreement(&[1.0], &[]), Err(StatsError::Unpaired { .. })));
        assert!(matches!(agreement(&[], &[]), Err(StatsError::TooFew { .. })));
        let nan = agreement(&[1.0, 2.0], &[1.0, f64::NAN]);
        assert!(matches!(nan, Err(StatsError::NonFinite { what: "simulated", index: 1, .. })));
    }
}
