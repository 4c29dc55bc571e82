//! Whether a name would rest on one person: then it is not given.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use effects::{Effect, EffectId};
use posterior::Posterior;

use crate::calibrated_person::CalibratedPerson;
use crate::error::GapError;
use crate::filter::calibration::CalibrationRule;
use crate::which::{Belief, believed, first_round, index_of_largest};

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

/// What a posterior read, to be read again without one person.
pub(crate) struct ReadAgain<'a> {
    pub(crate) people: &'a [CalibratedPerson<'a>],
    /// Number of people of the cohort, with those left out.
    pub(crate) asked: usize,
    pub(crate) library: &'a [Box<dyn Effect>],
    pub(crate) posterior: &'a Posterior,
    pub(crate) calibration: &'a CalibrationRule,
    /// What is read of free runs: of all people, or without the one of this index.
    pub(crate) free_runs: &'a dyn Fn(Option<usize>) -> BTreeMap<String, f64>,
}

impl ReadAgain<'_> {
    /// Those of these effects of which more than half of the log odds, over those before any data, is the person's who shows
    /// most. `gains` has the effects with each person's evidence.
    ///
    /// The posterior is asked again without that person; people are not analysed again. Where only one of several
    /// people is in use, everything rests on that one. A cohort of one person is asked as it is.
    ///
    /// # Errors
    /// As [`first_round`].
    pub(crate) fn on_one(
        &self,
        belief: &Belief,
        gains: &[(EffectId, &[f64])],
    ) -> Result<Vec<OnOne>, GapError> {
        if self.asked == 1 || self.people.len() > MOST_PEOPLE {
            return Ok(Vec::new());
        }
        let known = self.posterior.effects().len() as f64;
        let before = (1.0 - self.posterior.card().nothing) / known;
        let mut without_person: BTreeMap<usize, Belief> = BTreeMap::new();
        let mut resting = Vec::new();
        for (effect, gains) in gains {
            let person = index_of_largest(gains);
            let with = belief.of_known(*effect);
            let without = if self.people.len() == 1 {
                before
            } else {
                let rest = match without_person.entry(person) {
                    Entry::Occupied(known) => known.into_mut(),
                    Entry::Vacant(open) => open.insert(self.without(person)?),
                };
                rest.of_known(*effect)
            };
            if is_carried(with, without, before) {
                resting.push(OnOne { effect: *effect, person, without });
            }
        }
        Ok(resting)
    }

    /// What the posterior says without a person.
    fn without(&self, person: usize) -> Result<Belief, GapError> {
        let Self { people, library, posterior, calibration, free_runs, .. } = self;
        let others: Vec<CalibratedPerson<'_>> = others(people, person).copied().collect();
        let rest = first_round(&others, library, calibration, free_runs(Some(person)))?;
        believed(posterior, &rest.statistics)
    }
}

/// All but one.
pub(crate) fn others<T>(of: &[T], person: usize) -> impl Iterator<Item = &T> + Clone {
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
