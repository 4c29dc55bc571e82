//! Mean and standard deviation of a sample.

use contract::Summary;

use crate::StatsError;
use crate::error::{at_least, finite};

/// Mean and sample SD (denominator n - 1) of `values`, over people or over whatever they are.
///
/// # Errors
///
/// [`StatsError::TooFew`] for no value, [`StatsError::NonFinite`] for a NaN or an infinity.
pub fn summary(values: &[f64]) -> Result<Summary, StatsError> {
    at_least(1, "values", values.len())?;
    finite("value", values)?;
    let (mean, sd) = mean_and_sd(values);
    Ok(Summary { n: values.len(), mean, sd: (values.len() > 1).then_some(sd) })
}

/// Mean; 0/0 where there is no value.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean and sample SD in two passes; the SD is exactly 0 where all values are the same.
pub(crate) fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    if values.iter().all(|v| *v == values[0]) {
        return (values.first().copied().unwrap_or(f64::NAN), 0.0);
    }
    let mean = mean(values);
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (mean, (squares / (values.len() as f64 - 1.0)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_value_has_no_sd() {
        assert_eq!(summary(&[3.0]), Ok(Summary { n: 1, mean: 3.0, sd: None }));
        assert!(summary(&[]).is_err());
        assert!(summary(&[1.0, f64::NAN]).is_err());
    }

    #[test]
    fn sd_divides_by_n_minus_one() {
        let summary = summary(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]).expect("finite");
        assert_eq!(summary.mean, 5.0);
        // Sum of squares 32 over 7 degrees of freedom; one rounding of the square root.
        assert!((summary.sd.expect("n > 1") - (32.0_f64 / 7.0).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn identical_values_vary_by_nothing() {
        // 0.1 summed ten times is not 1, so a naive mean would leave a spurious SD of 1e-17.
        assert_eq!(summary(&[0.1; 10]).expect("finite").sd, Some(0.0));
    }
}
