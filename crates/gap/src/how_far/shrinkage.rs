//! Share of the removable error that was removed.

use stats::Bootstrap;

use super::small_sample::over_people;
use crate::error::GapError;
use contract::WithInterval;

/// How much of what an oracle would remove was removed: before minus after over before minus oracle, means over people.
/// `None` where the interval of what is removable includes the margin, or all of it lies below.
///
/// The errors are everyone's, mg/dL, one value a person in the same order.
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
) -> Result<Option<WithInterval>, GapError> {
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
        vec![removable, share]
    })?;
    let of = |index| -> Result<WithInterval, GapError> {
        Ok(over_people(&matrix.estimate(index, plan.level)?, people.len()))
    };
    if of(0)?.lower > margin { of(1).map(Some) } else { Ok(None) }
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
        let share = found.expect("4 mg/dL can be removed");
        // Everyone alike: rounding only.
        assert!((share.value - 0.75).abs() < 1e-12 && (share.upper - share.lower).abs() < 1e-12);
    }

    #[test]
    fn where_next_to_nothing_can_be_removed_no_share_is_given() {
        let before = [20.0, 24.0, 22.0, 26.0, 21.0];
        let oracle = [19.9, 24.3, 21.7, 25.9, 21.2];
        let found = shrinkage(&before, &before, &oracle, 0.5, &PLAN).expect("five people");
        assert_eq!(found, None);
        assert!(shrinkage(&before, &before[..4], &oracle, 0.5, &PLAN).is_err());
    }
}
