//! Share of the removable error that was removed.

use serde::{Deserialize, Serialize};
use stats::Bootstrap;

use super::small_sample::over_people;
use crate::error::GapError;
use contract::WithInterval;

/// How much of what an oracle would remove was removed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Shrinkage {
    /// Before minus after, mg/dL: mean over people.
    pub removed: WithInterval,
    /// Before minus oracle, mg/dL: mean over people.
    pub removable: WithInterval,
    /// Removed over removable; `None` where the interval of what is removable includes the margin, or all
    /// of it lies below.
    pub share: Option<WithInterval>,
}

/// Shrinkage from everyone's errors, mg/dL, one value a person in the same order.
///
/// `oracle` holds the errors of the same refit with the true effect (or a floor). Intervals are percentiles
/// of a bootstrap over people, the three errors of a person drawn together, widened as few people need. `margin` is the smallest
/// removable error, mg/dL, of which a share says anything.
///
/// # Errors
/// [`GapError::Statistics`]: lists of different length, fewer than two people, numbers that are not
/// finite.
pub fn shrinkage(
    before: &[f64],
    after: &[f64],
    oracle: &[f64],
    margin: f64,
    plan: &Bootstrap,
) -> Result<Shrinkage, GapError> {
    for other in [after.len(), oracle.len()] {
        if other != before.len() {
            return Err(stats::StatsError::Unpaired { left: before.len(), right: other }.into());
        }
    }
    let people: Vec<[f64; 3]> =
        before.iter().zip(after).zip(oracle).map(|((b, a), o)| [*b, *a, *o]).collect();
    let matrix = plan.people_matrix(&people, |drawn| {
        let n = drawn.len() as f64;
        let mean = |index: usize| drawn.iter().map(|errors| errors[index]).sum::<f64>() / n;
        let (removed, removable) = (mean(0) - mean(1), mean(0) - mean(2));
        // A replicate without anything to remove cannot enter a share; where that can happen the share
        // is withheld.
        let share = if removable > 0.0 { removed / removable } else { 0.0 };
        vec![removed, removable, share]
    })?;
    let of = |index| -> Result<WithInterval, GapError> {
        Ok(over_people(&matrix.estimate(index, plan.level)?, people.len()))
    };
    let removable = of(1)?;
    let share = if removable.lower > margin { Some(of(2)?) } else { None };
    Ok(Shrinkage { removed: of(0)?, removable, share })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: Bootstrap = Bootstrap { replicates: 500, level: 0.95, seed: 2 };

    #[test]
    fn the_share_is_what_was_removed_over_what_could_be() {
        let before = [20.0, 24.0, 22.0, 26.0, 21.0];
        let oracle = before.map(|error| error - 4.0);
        let after = before.map(|error| error - 3.0);
        let found = shrinkage(&before, &after, &oracle, 0.5, &PLAN).expect("five people");
        let share = found.share.expect("4 mg/dL can be removed");
        // Everyone alike: rounding only.
        assert!((share.value - 0.75).abs() < 1e-12 && (share.upper - share.lower).abs() < 1e-12);
        assert!((found.removed.value - 3.0).abs() < 1e-12);
    }

    #[test]
    fn where_next_to_nothing_can_be_removed_no_share_is_given() {
        let before = [20.0, 24.0, 22.0, 26.0, 21.0];
        let oracle = [19.9, 24.3, 21.7, 25.9, 21.2];
        let found = shrinkage(&before, &before, &oracle, 0.5, &PLAN).expect("five people");
        assert_eq!(found.share, None);
        assert!(shrinkage(&before, &before[..4], &oracle, 0.5, &PLAN).is_err());
    }
}
