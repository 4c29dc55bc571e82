//! Adjustment for asking several questions: Holm.

use crate::StatsError;
use crate::error::domain;

/// Holm (1979) adjusted p-values, in the order given; controls the family-wise error under any
/// dependence.
///
/// # Errors
///
/// [`StatsError::OutOfDomain`] for a p-value below 0, above 1 or NaN.
pub fn holm(p: &[f64]) -> Result<Vec<f64>, StatsError> {
    for value in p {
        domain((0.0..=1.0).contains(value), "p", *value, "a p-value between 0 and 1")?;
    }
    // The earlier first among equals.
    let mut ascending: Vec<usize> = (0..p.len()).collect();
    ascending.sort_by(|a, b| p[*a].total_cmp(&p[*b]));
    let mut adjusted = vec![0.0; p.len()];
    let mut so_far: f64 = 0.0;
    for (rank, index) in ascending.into_iter().enumerate() {
        so_far = so_far.max((p.len() - rank) as f64 * p[index]).min(1.0);
        adjusted[index] = so_far;
    }
    Ok(adjusted)
}
