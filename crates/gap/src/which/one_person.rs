//! Whether a name would rest on one person: then it is not given.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use effects::EffectId;
use posterior::Posterior;

use super::{Belief, NAMED_FROM, Score, index_of_largest};
use crate::error::GapError;

/// People beyond whom none of them can carry a name.
const MOST_PEOPLE: usize = 20;

/// A name that would rest on one person.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OnOne {
    pub(crate) effect: EffectId,
    /// The person's index.
    pub(crate) person: usize,
    /// The probability without the person.
    pub(crate) without: f64,
}

/// Those of the probable effects of which more than half of the log odds, over those before any data, is the person's who
/// shows most. `people` are in use, of `asked`.
///
/// The posterior is asked again `without` the person of an index; people are not analysed again. Where only one of several
/// people is in use, everything rests on that one. A cohort of one person is asked as it is.
///
/// # Errors
/// Those of `without`.
pub(super) fn on_one(
    scores: &[Score],
    belief: &Belief,
    posterior: &Posterior,
    (people, asked): (usize, usize),
    without: impl Fn(usize) -> Result<Belief, GapError>,
) -> Result<Vec<OnOne>, GapError> {
    if asked == 1 || people > MOST_PEOPLE || !belief.alarms() {
        return Ok(Vec::new());
    }
    let before = (1.0 - posterior.card().nothing) / posterior.effects().len() as f64;
    let mut beliefs: BTreeMap<usize, Belief> = BTreeMap::new();
    let mut resting = Vec::new();
    for score in scores {
        let (effect, person) = (score.effect, index_of_largest(&score.gains));
        let with = belief.of_known(effect);
        if with < NAMED_FROM {
            continue;
        }
        let without = if people == 1 {
            before
        } else {
            let rest = match beliefs.entry(person) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(open) => open.insert(without(person)?),
            };
            rest.of_known(effect)
        };
        if is_carried(with, without, before) {
            resting.push(OnOne { effect, person, without });
        }
    }
    Ok(resting)
}

/// All but one.
pub(super) fn others<T>(of: &[T], person: usize) -> impl Iterator<Item = &T> {
    of.iter().enumerate().filter(move |(index, _)| *index != person).map(|(_, own)| own)
}

/// Whether more than half of the log odds over those before any data goes with the person.
fn is_carried(with: f64, without: f64, before: f64) -> bool {
    let logit = |p: f64| {
        let p = p.clamp(1e-9, 1.0 - 1e-9);
        (p / (1.0 - p)).ln()
    };
    logit(without) - logit(before) < 0.5 * (logit(with) - logit(before))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_carried_where_its_odds_go_with_the_person() {
        // Odds of 3 over prior odds of 1 in 27: half of it in logarithms is odds of 1 in 3.
        let before = 1.0 / 28.0;
        assert!(is_carried(0.75, 0.2, before));
        assert!(!is_carried(0.75, 0.3, before));
        assert!(!is_carried(0.75, 0.9, before));
        assert!(is_carried(1.0, 0.0, before));
    }

    #[test]
    fn the_others_are_all_but_one() {
        assert_eq!(others(&[1, 2, 3], 1).copied().collect::<Vec<_>>(), [1, 3]);
    }
}
