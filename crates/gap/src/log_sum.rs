//! Sums and shares of exponentials, none of which overflows, and moments under such shares.

/// Logarithms further below the largest are left out of a sum: they add less than rounding does.
const NEGLIGIBLE: f64 = -40.0;

/// Logarithm of the sum of exponentials; minus infinity for an empty list.
pub(crate) fn log_sum(logs: &[f64]) -> f64 {
    let top = largest(logs);
    if top == f64::NEG_INFINITY {
        return top;
    }
    let below = logs.iter().map(|log| log - top).filter(|below| *below > NEGLIGIBLE);
    top + below.map(f64::exp).sum::<f64>().ln()
}

/// Logarithm of the likelihood ratio of something that happens with a probability: 1 - p + p e^ratio.
pub(crate) fn log_with_probability(ratio: f64, p: f64) -> f64 {
    let (off, on) = ((-p).ln_1p(), p.ln() + ratio);
    let top = off.max(on);
    top + ((off - top).exp() + (on - top).exp()).ln()
}

/// Exponentials over the largest of them.
pub(crate) fn raised(logs: &[f64]) -> Vec<f64> {
    let top = largest(logs);
    logs.iter().map(|log| (log - top).exp()).collect()
}

/// Shares of each by its exponential; they add up to 1.
pub(crate) fn softmax(logs: &[f64]) -> Vec<f64> {
    let raised = raised(logs);
    let sum: f64 = raised.iter().sum();
    raised.iter().map(|raised| raised / sum).collect()
}

/// Mean and standard deviation of values under some weights.
pub(crate) fn moments<const N: usize>(weights: &[f64], values: [f64; N]) -> (f64, f64) {
    let both = || weights.iter().zip(values);
    let sum: f64 = weights.iter().sum();
    let mean = both().map(|(w, x)| w * x).sum::<f64>() / sum;
    let square = both().map(|(w, x)| w * (x - mean).powi(2)).sum::<f64>() / sum;
    (mean, square.sqrt())
}

fn largest(logs: &[f64]) -> f64 {
    logs.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_exponentials_where_these_do_not_overflow() {
        let logs = [0.3, -1.0, 2.0, f64::NEG_INFINITY];
        let sum: f64 = logs.iter().map(|log| log.exp()).sum();
        // Rounding.
        assert!((log_sum(&logs) - sum.ln()).abs() < 1e-14);
        for (share, log) in softmax(&logs).into_iter().zip(logs) {
            assert!((share - log.exp() / sum).abs() < 1e-14);
        }
        let with = log_with_probability(0.7, 0.1);
        assert!((with - (0.9 + 0.1 * 0.7_f64.exp()).ln()).abs() < 1e-14);
        assert!((log_sum(&[1e4, 1e4]) - (1e4 + 2.0_f64.ln())).abs() < 1e-11);
        assert_eq!(log_sum(&[]), f64::NEG_INFINITY);
        assert!((log_with_probability(1e4, 0.5) - (1e4 - 2.0_f64.ln())).abs() < 1e-11);
    }
}
