//! Counted shares with their intervals, and other figures with theirs.

use contract::blind_check::Share;

use stats::{Bootstrap, proportion};

use crate::error::BlindError;

/// Confidence level of every two-sided interval.
pub(crate) const LEVEL: f64 = 0.95;
/// Replicates of the bootstrap over worlds.
const REPLICATES: usize = 2000;

/// `count` of `of`.
///
/// # Errors
/// If the count exceeds the total.
pub(crate) fn share(count: usize, of: usize) -> Result<Share, BlindError> {
    let exact = proportion::clopper_pearson(count, of, LEVEL)?;
    let score = proportion::wilson(count, of, LEVEL)?;
    Ok(Share {
        count,
        of,
        value: (of > 0).then(|| count as f64 / of as f64),
        lower: exact.lower,
        upper: exact.upper,
        wilson_lower: score.lower,
        wilson_upper: score.upper,
    })
}

/// For how many of the items `is` holds.
pub(crate) fn among<T>(
    items: impl IntoIterator<Item = T>,
    is: impl Fn(&T) -> bool,
) -> Result<Share, BlindError> {
    let (mut count, mut of) = (0, 0);
    for item in items {
        of += 1;
        count += usize::from(is(&item));
    }
    share(count, of)
}

/// Limits of the bootstrap interval of a statistic over worlds; `None` below two worlds.
pub(crate) fn interval_over_worlds<W: Sync>(
    worlds: &[W],
    seed: u64,
    statistic: impl Fn(&[&W]) -> f64 + Sync,
) -> Result<Option<(f64, f64)>, BlindError> {
    if worlds.len() < 2 {
        return Ok(None);
    }
    let plan = Bootstrap { replicates: REPLICATES, level: LEVEL, seed };
    let estimate = plan.people(worlds, statistic)?;
    Ok(Some((estimate.percentile.lower, estimate.percentile.upper)))
}
