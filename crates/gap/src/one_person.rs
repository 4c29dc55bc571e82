//! Whether a name rests on one person.

use effects::{Effect, EffectId};
use posterior::Posterior;

use crate::calibrated_person::CalibratedPerson;
use crate::config::DiagnosisConfig;
use crate::error::GapError;
use crate::free_run_statistics::free_run_statistics;
use crate::person::PersonAnalysis;
use crate::which::{Named, Which, believed, first_round};

/// People beyond whom none of them can carry a name.
const MOST_PEOPLE: usize = 20;

/// A name that rests on one person.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OnOne {
    pub(crate) effect: EffectId,
    /// The person's index.
    pub(crate) person: usize,
    /// The probability without the person.
    pub(crate) without: f64,
}

/// The names of which more than half of the log odds, over those before any data, is the person's who shows most.
///
/// The posterior is asked again without that person; people are not analysed again.
///
/// # Errors
/// As [`first_round`].
pub(crate) fn on_one(
    found: &Which,
    inputs: &[CalibratedPerson<'_>],
    analyses: &[&PersonAnalysis],
    library: &[Box<dyn Effect>],
    posterior: &Posterior,
    config: &DiagnosisConfig,
) -> Result<Vec<OnOne>, GapError> {
    let belief = &found.belief;
    if !(2..=MOST_PEOPLE).contains(&inputs.len()) {
        return Ok(Vec::new());
    }
    let before = (1.0 - posterior.card().nothing) / posterior.effects().len() as f64;
    let mut beliefs_without: Vec<(usize, crate::which::Belief)> = Vec::new();
    let mut resting = Vec::new();
    let known = |named: &&Named| posterior.effects().iter().any(|e| e == named.effect.name());
    for named in found.named.iter().filter(known) {
        let person = who_shows_most(named);
        if beliefs_without.iter().all(|(known, _)| *known != person) {
            let people: Vec<CalibratedPerson<'_>> = others(inputs, person).copied().collect();
            let free_runs = free_run_statistics(others(analyses, person).copied(), config);
            let rest = first_round(&people, library, &config.calibration, free_runs)?.statistics;
            beliefs_without.push((person, believed(posterior, &rest)?));
        }
        let Some((_, rest)) = beliefs_without.iter().find(|(known, _)| *known == person) else {
            continue;
        };
        let (with, without) = (belief.of_known(named.effect), rest.of_known(named.effect));
        if is_carried(with, without, before) {
            resting.push(OnOne { effect: named.effect, person, without });
        }
    }
    Ok(resting)
}

fn others<T>(of: &[T], person: usize) -> impl Iterator<Item = &T> + Clone {
    of.iter().enumerate().filter(move |(index, _)| *index != person).map(|(_, own)| own)
}

/// The person with the largest evidence.
fn who_shows_most(named: &Named) -> usize {
    let people = 0..named.gains.len();
    people.max_by(|a, b| named.gains[*a].total_cmp(&named.gains[*b])).unwrap_or(0)
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
