//! Effects of a user's own, which no posterior knows, held against those of the library.
//!
//! How much evidence a plant's misfit gives to an effect that does not act depends on the plant, the people and the
//! length of the record, and no table holds it for an effect that somebody has just written. The cohort itself tells:
//! the library's effects gain from the same misfit. So an effect of one's own is weighed against nothing and against
//! every effect of the library that is tested in the same way, by their held-out evidence and equal odds before any data.
//! (Searches of spectra count false matches in the same way, by decoys: Elias and Gygi, Nat Methods 2007;4:207.)

use effects::EffectId;

use super::Score;
use crate::log_sum::log_sum;

/// Odds against an effect before any data: about those against each effect of the library.
const ODDS_AGAINST: f64 = 50.0;

/// The scores, the largest evidence first. Effects that are not `known` get the probability that they have beside the
/// others. A guard is no measure: it belongs to the background of every effect that is tested.
pub(super) fn beside_the_library(
    mut scores: Vec<Score>,
    known: impl Fn(EffectId) -> bool,
    is_guard: impl Fn(EffectId) -> bool,
) -> Vec<Score> {
    let own = |score: &Score| {
        let alike = scores.iter().filter(|other| other.test == score.test);
        let decoys = alike.filter(|other| known(other.effect) && !is_guard(other.effect));
        let against: Vec<f64> = decoys.map(Score::gain).chain([ODDS_AGAINST.ln()]).collect();
        let probability = 1.0 / (1.0 + (log_sum(&against) - score.gain()).exp());
        (!known(score.effect)).then_some(probability)
    };
    let own: Vec<Option<f64>> = scores.iter().map(own).collect();
    for (score, own) in scores.iter_mut().zip(own) {
        score.own = own;
    }
    scores.sort_by(|a, b| b.gain().total_cmp(&a.gain()));
    scores
}

#[cfg(test)]
mod tests {
    use super::super::Test;
    use super::*;

    const OWN: EffectId = EffectId::new("coffee");

    fn events(effect: EffectId, gain: f64) -> Score {
        Score::of(effect, Test::Events, vec![gain])
    }

    fn probability(others: &[Score], own: f64) -> f64 {
        let mut scores = vec![events(OWN, own)];
        scores.extend_from_slice(others);
        let found = beside_the_library(scores, |id| id != OWN, |_| false);
        assert!(found.iter().all(|c| c.own.is_some() == (c.effect == OWN)), "{found:?}");
        assert!(found.is_sorted_by(|a, b| a.gain() >= b.gain()));
        found.iter().find_map(|score| score.own).expect("one of its own")
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
        let spread = Score::of(EffectId::INSULIN_ABSORPTION, Test::Random, vec![90.0]);
        let found = beside_the_library(vec![events(OWN, 20.0), spread], |id| id != OWN, |_| false);
        assert!(found[1].own.is_some_and(|p| p > 0.99), "{found:?}");
    }
}
