//! Effects of a user's own, which no posterior knows, held against those of the library.
//!
//! How much evidence a plant's misfit gives to an effect that does not act depends on the plant, the people and the
//! length of the record, and no table holds it for an effect that somebody has just written. The cohort itself tells:
//! the library's effects gain from the same misfit. So an effect of one's own is weighed against nothing and against
//! every effect of the library that is tested in the same way, by their held-out evidence and equal odds before any data.
//! (Searches of spectra count false matches in the same way, by decoys: Elias and Gygi, Nat Methods 2007;4:207.)

use std::mem::discriminant;

use effects::EffectId;

use super::Candidate;
use super::round::Score;
use crate::log_sum::log_sum;

/// Odds against an effect before any data: about those against each effect of the library.
const ODDS_AGAINST: f64 = 50.0;

/// Every effect that was scored, the largest evidence first. Those that are not `known` get the probability
/// that they have beside the others. A guard is no measure: it belongs to the background of every effect that is tested.
pub(super) fn beside_the_library(
    scores: &[Score],
    known: impl Fn(EffectId) -> bool,
    is_guard: impl Fn(EffectId) -> bool,
) -> Vec<Candidate> {
    let own = |score: &Score| {
        let decoys = scores.iter().filter(|other| {
            let alike = discriminant(&other.evidence) == discriminant(&score.evidence);
            alike && known(other.effect) && !is_guard(other.effect)
        });
        let against: Vec<f64> = decoys.map(Score::gain).chain([ODDS_AGAINST.ln()]).collect();
        1.0 / (1.0 + (log_sum(&against) - score.gain()).exp())
    };
    let mut candidates: Vec<Candidate> = scores
        .iter()
        .map(|score| Candidate {
            effect: score.effect,
            gain: score.gain(),
            own: (!known(score.effect)).then(|| own(score)),
        })
        .collect();
    candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    candidates
}

#[cfg(test)]
mod tests {
    use super::super::events::EventEvidence;
    use super::super::random_effects::UnitEvidence;
    use super::super::round::ScoreOf;
    use super::*;

    const OWN: EffectId = EffectId::new("coffee");

    fn events(effect: EffectId, gain: f64) -> Score {
        let found = EventEvidence { gains: vec![gain], found: Vec::new() };
        Score { effect, evidence: ScoreOf::Events(found) }
    }

    fn probability(others: &[Score], own: f64) -> f64 {
        let known = |id| id != OWN;
        let mut scores = vec![events(OWN, own)];
        scores.extend(others.iter().map(|other| events(other.effect, other.gain())));
        let found = beside_the_library(&scores, known, |_| false);
        assert!(found.iter().all(|c| c.own.is_some() == (c.effect == OWN)), "{found:?}");
        assert!(found.is_sorted_by(|a, b| a.gain >= b.gain));
        found.iter().find_map(|candidate| candidate.own).expect("one of its own")
    }

    #[test]
    fn an_effect_of_ones_own_must_explain_more_than_the_library_does() {
        let library = [events(EffectId::ALCOHOL, 7.0), events(EffectId::MISSED_MEALS, -3.0)];
        let even = (ODDS_AGAINST + 7f64.exp() + (-3f64).exp()).ln();
        assert!((probability(&library, even) - 0.5).abs() < 1e-12);
        assert!((probability(&[], ODDS_AGAINST.ln()) - 0.5).abs() < 1e-12);
        // Evidence against an effect of the library is no help.
        assert!((probability(&library[1..], ODDS_AGAINST.ln()) - 0.5).abs() < 1e-3);
        assert!(probability(&library, 30.0) > 0.99 && probability(&library, 1.0) < 0.01);
    }

    #[test]
    fn what_is_tested_in_another_way_is_no_measure() {
        let spread = UnitEvidence { gains: vec![90.0], spread: (0.2, 0.1) };
        let spread = ScoreOf::Random(spread, 0.18);
        let scores =
            [events(OWN, 20.0), Score { effect: EffectId::INSULIN_ABSORPTION, evidence: spread }];
        let found = beside_the_library(&scores, |id| id != OWN, |_| false);
        assert!(found[1].own.is_some_and(|p| p > 0.99), "{found:?}");
    }
}
