//! The evidence of every effect in one round.

use effects::{Card, EffectId, ShownBy};
use rayon::prelude::*;

use super::Score;
use super::events;
use super::held_out::held_out;
use super::lag;
use super::random_effects::{self, UnitSums, UnitTrial};
use super::round::Round;
use super::statistics::RANDOM;
use super::tried::Tried;
use crate::design::EventBank;

impl Round {
    /// Evidence of every effect that is not named yet.
    pub(super) fn scores(&self, tried: &Tried<'_>, named: &[Score]) -> Vec<Score> {
        let cards = tried.effects.par_iter().map(|effect| effect.card());
        let open = cards.filter(|card| named.iter().all(|n| n.effect != card.id));
        open.filter_map(|card| self.score(&card)).collect()
    }

    /// Evidence of one effect, `None` where no record can show it.
    fn score(&self, card: &Card) -> Option<Score> {
        if card.relations.shown_by == ShownBy::SensorLag {
            return Some(lag::score(card.id, &self.lags));
        }
        let trials = self.trials(card);
        if trials.iter().any(|trial| !trial.variants.is_empty()) {
            return Some(held_out(card.id, &trials));
        }
        let banks = self.subjects.iter().map(|s| s.events.iter().find(|b| b.effect == card.id));
        let banks: Vec<Option<&EventBank>> = banks.collect();
        if banks.iter().any(Option::is_some) {
            let days = self.subjects.iter().map(|s| s.statistics.days.len());
            return Some(events::score(card.id, &banks, &days.collect::<Vec<_>>()));
        }
        self.random(card.id)
    }

    /// Evidence of a random effect: a factor that is drawn for every unit.
    pub(super) fn random(&self, effect: EffectId) -> Option<Score> {
        let known = |units: &&UnitSums| units.effect == effect;
        let units = self.subjects.iter().flat_map(|s| &s.units).find(known)?;
        let mut spreads = self.estimated.spreads;
        // The same factor by day of the record is not allowed for beside it.
        if let Some(factor) = RANDOM.iter().position(|random| random.field == units.field) {
            spreads.day[factor] = 0.0;
        }
        let trials: Vec<UnitTrial<'_>> = self
            .subjects
            .iter()
            .enumerate()
            .map(|(person, subject)| UnitTrial {
                person: &subject.statistics,
                units: subject.units.iter().find(known),
                allowed: self.allowed(person, None),
            })
            .collect();
        Some(random_effects::score(units, &trials, &spreads))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Test;
    use super::super::round::RoundPerson;
    use super::super::sample::{DAWN, EXERCISE, INSULIN_TIME, design, only, week, with_tried};
    use super::*;

    const NAMES: [&str; 3] = ["dawn", "exercise", "insulin_absorption"];

    fn scores(people: Vec<RoundPerson>) -> Vec<Score> {
        with_tried(&NAMES, |tried| Round::estimated(people, Vec::new()).scores(tried, &[]))
    }

    #[test]
    fn a_planted_effect_scores_what_its_design_says() {
        for scale in [1.0, 2.0] {
            let found = scores([0.3, 0.5].map(|size| week(DAWN[1], scale * size)).into());
            let dawn = &found[0];
            // People's own amplitudes lie between what they show and the mean of both.
            for (own, shown) in dawn.personal.iter().zip([0.3, 0.5]) {
                assert!((own.0 / scale - shown).abs() < 0.1, "{:?}", dawn.personal);
            }
            let mean = dawn.amplitude.0;
            assert!(dawn.personal[0].0 < mean && mean < dawn.personal[1].0);
            assert_eq!(dawn.variants, [1, 1]);
            assert!(found[0].gain() > 4.0 && found[0].gain() > found[1].gain());
        }
    }

    #[test]
    fn the_order_of_people_changes_nothing() {
        let people = || vec![week(DAWN[0], 0.4), week(EXERCISE, 0.7), week(DAWN[0], 0.9)];
        let mut other = people();
        other.reverse();
        for (one, other) in scores(people()).iter().zip(scores(other)) {
            for (a, b) in one.gains.iter().zip(other.gains.iter().rev()) {
                assert!((a - b).abs() < 1e-9, "{}: {a} {b}", one.effect); // rounding of sums
            }
        }
    }

    #[test]
    fn a_factor_of_every_day_is_scored_without_its_like_in_the_background() {
        let by_day = [0.5, -0.4, 0.3, -0.5, 0.4, -0.2, 0.1];
        let varied = || vec![RoundPerson::of(&design(only(0, 0.0), &by_day))];
        let of = |round: &Round| {
            let found = round.random(EffectId::INSULIN_ABSORPTION).expect("a bank of units");
            (found.gains[0], found.amplitude.0)
        };
        let mut round = Round::estimated(varied(), Vec::new());
        round.estimated.spreads.day = [0.0; RANDOM.len()];
        let (gain, size) = of(&round);
        // Root mean square 0.37 where 0.18 is published; a spread of seven numbers has a relative error of a quarter.
        assert!(gain > 1.0 && (0.18 * size - 0.37).abs() < 0.1, "{gain} {size}");
        round.estimated.spreads.day[INSULIN_TIME] = 0.3;
        assert_eq!(of(&round), (gain, size));
        let even = Round::estimated(vec![week(0, 0.0)], Vec::new());
        assert!(of(&even).0 <= 0.0 && of(&even).1 < 0.5 * size);
    }

    #[test]
    fn a_spread_is_everybodys_and_not_tried_again() {
        let round = Round::estimated(vec![week(0, 0.0), week(0, 0.0)], Vec::new());
        let scored = |named: &[Score]| {
            with_tried(&["dawn", "insulin_absorption"], |tried| round.scores(tried, named))
        };
        let found = scored(&[]);
        assert_eq!([found[0].test, found[1].test], [Test::Driven, Test::Random]);
        assert_eq!(found[1].personal, [found[1].amplitude; 2]);
        let left = scored(&found[1..]);
        assert_eq!((left.len(), left[0].effect), (1, EffectId::DAWN));
    }

    #[test]
    fn nobody_and_what_no_record_can_show_have_no_score() {
        assert!(scores(Vec::new()).is_empty());
        let round = Round::estimated(vec![week(DAWN[0], 0.4)], Vec::new());
        let names = ["set_ageing", "missed_meals", "slow_meals"];
        assert!(with_tried(&names, |tried| round.scores(tried, &[]).is_empty()));
    }
}
