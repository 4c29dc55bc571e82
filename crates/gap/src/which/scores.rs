//! The evidence of every effect in one round.

use effects::{EffectId, ShownBy};
use rayon::prelude::*;

use super::Named;
use super::by_unit::{self, UnitTrial};
use super::events;
use super::held_out::held_out;
use super::lag;
use super::round::{Round, Score, ScoreOf};
use super::statistics;
use super::tried::Tried;
use crate::design::EventBank;

impl Round {
    /// Evidence of every effect that is not named yet.
    pub(super) fn scores(&self, tried: &Tried<'_>, named: &[Named]) -> Vec<Score> {
        let days: Vec<usize> = self.subjects.iter().map(|s| s.statistics.days.len()).collect();
        tried
            .effects()
            .par_iter()
            .map(|effect| effect.card())
            .filter(|card| named.iter().all(|n| n.effect != card.id))
            .filter_map(|card| {
                let effect = card.id;
                if card.relations.shown_by == ShownBy::SensorLag {
                    let lags: Vec<&lag::Likelihoods> =
                        self.subjects.iter().filter_map(|s| s.lags.as_ref()).collect();
                    return Some(Score { effect, evidence: ScoreOf::Lag(lag::score(&lags)) });
                }
                let trials = self.trials(&card);
                if trials.iter().any(|trial| !trial.variants.is_empty()) {
                    let evidence = ScoreOf::Driven(held_out(&trials));
                    return Some(Score { effect, evidence });
                }
                let banks: Vec<Option<&EventBank>> = self
                    .subjects
                    .iter()
                    .map(|s| s.events.iter().find(|bank| bank.effect == effect))
                    .collect();
                if banks.iter().any(Option::is_some) {
                    let evidence = events::score(&banks, &days);
                    return Some(Score { effect, evidence: ScoreOf::Events(evidence) });
                }
                let evidence = self.random(effect)?;
                Some(Score { effect, evidence })
            })
            .collect()
    }

    /// Evidence that a factor is drawn anew for every unit.
    pub(super) fn random(&self, effect: EffectId) -> Option<ScoreOf> {
        let banks = self.subjects.iter().flat_map(|s| &s.design.random);
        let bank = banks.into_iter().find(|bank| bank.effect == effect)?;
        let mut spreads = self.estimated.spreads;
        // The same factor by day of the record is not allowed for beside it.
        if let Some(place) = statistics::random_place(bank.field) {
            spreads.day[place] = 0.0;
        }
        let trials: Vec<UnitTrial<'_>> = self
            .subjects
            .iter()
            .enumerate()
            .map(|(person, subject)| UnitTrial {
                person: &subject.statistics,
                units: subject.units.iter().find(|units| units.effect == effect),
                allowed: self.allowed(person, None),
            })
            .collect();
        Some(ScoreOf::Random(by_unit::score(&trials, &spreads), bank.log_sd))
    }
}
