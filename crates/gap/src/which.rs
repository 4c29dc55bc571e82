//! Which effect is missing: candidates against the background, one after the other.
//!
//! Every effect of the library is tested by held-out evidence on the linear model of the innovations
//! ([`design`](crate::design)), with the background profiled and random differences between days integrated
//! out. A posterior reads what the first round shows and says which effects are probable; an effect that it does not
//! know is held against those of the library (`own_effects`). Once one is named, the plant is run again with it,
//! and the others are tested on what is left.

mod amplitude;
mod answer;
mod backgrounds;
pub mod ceiling;
mod conditioned;
mod events;
mod folds;
mod held_out;
mod lag;
mod one_person;
mod own_effects;
mod random_effects;
mod round;
#[cfg(test)]
mod sample;
mod scores;
mod statistics;
mod tried;
mod variance;

use contract::diagnosis::Evidence;
use std::collections::BTreeMap;

use effects::{Effect, EffectId};
use physiology::STEPS_PER_DAY;
use posterior::Posterior;

use self::one_person::{OnOne, on_one, others};
use self::round::Round;
use self::tried::Tried;
use crate::calibrated_person::CalibratedPerson;
use crate::cohort_statistics::{evidence_of_people, statistics};
use crate::error::GapError;
use crate::filter::calibration::CalibrationRule;
use crate::units::{self, PortCourse};

pub(crate) use self::answer::is_free;
pub use self::events::FoundEvent;

/// What the first round shows, in which nothing is named.
#[derive(Debug, Clone)]
pub struct FirstRound {
    /// Every effect that was tried, the largest evidence first.
    pub candidates: Vec<Score>,
    /// Effects that no record could show.
    pub untried: Vec<EffectId>,
    /// The evidence by name.
    pub evidence: Evidence,
    /// Spreads of the random factors, log or relative, by port: `egp/day`, `egp/block` and so on.
    pub spreads: BTreeMap<String, f64>,
    /// What a posterior reads of the cohort.
    pub statistics: BTreeMap<String, f64>,
    /// What is lacking at the ports through the day.
    pub(crate) courses: Vec<PortCourse>,
}

/// The answer to "which".
#[derive(Debug, Clone)]
pub struct Which {
    /// The effects named, in the order of conditioning.
    pub named: Vec<Score>,
    /// Those that are probable enough to be named and rest on one person.
    pub(crate) withheld: Vec<OnOne>,
    /// What the first round showed.
    pub first: FirstRound,
    /// What the posterior says of it.
    pub belief: Belief,
    /// Evidence by port and scale, once the named effects are conditioned on.
    pub(crate) ports: BTreeMap<String, f64>,
}

/// Probability from which on an effect is named where something is missing: it is more likely there than not.
pub(crate) const NAMED_FROM: f64 = 0.5;

/// What a posterior says.
#[derive(Debug, Clone, PartialEq)]
pub struct Belief {
    /// Its probabilities.
    pub answer: posterior::Answer,
    /// Probability from which on something is said to be missing, with a name or without.
    pub speaks_from: f64,
}

impl Belief {
    /// The most probable of the effects that may be named next: those that the posterior knows, and the user's own by
    /// their odds beside the library. The user's own come first.
    fn next<'a>(&self, candidates: &'a [Score], withheld: &[OnOne]) -> Option<&'a Score> {
        let best = |own: bool| {
            let open = candidates.iter().filter(|c| c.own.is_some() == own);
            let probable = open.filter(|c| self.of(c) >= NAMED_FROM && (own || self.alarms()));
            let shared = probable.filter(|c| withheld.iter().all(|one| one.effect != c.effect));
            shared.max_by(|a, b| self.of(a).total_cmp(&self.of(b)))
        };
        best(true).or_else(|| best(false))
    }

    /// The probability of an effect that was tried.
    pub(crate) fn of(&self, score: &Score) -> f64 {
        score.own.unwrap_or_else(|| self.of_known(score.effect))
    }

    /// The probability of an effect; 0 of one that the posterior does not know.
    pub(crate) fn of_known(&self, id: EffectId) -> f64 {
        let own = self.answer.effects.iter().find(|(name, _)| name == id.name());
        own.map_or(0.0, |(_, p)| *p)
    }

    /// Whether something is said to be missing.
    pub(crate) fn alarms(&self) -> bool {
        1.0 - self.answer.nothing >= self.speaks_from
    }
}

/// How an effect is tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Test {
    /// By its course, which follows from the record.
    Driven,
    /// By hidden events.
    Events,
    /// By the likelihoods of other lags of the sensor.
    Lag,
    /// By a factor that is drawn for every unit.
    Random,
}

/// What the test of an effect shows.
#[derive(Debug, Clone)]
pub struct Score {
    /// Which effect.
    pub effect: EffectId,
    /// How it is tested.
    pub(crate) test: Test,
    /// Each person's held-out evidence, nats.
    pub gains: Vec<f64>,
    /// Of an effect that no posterior knows: its probability beside the effects of the library.
    pub own: Option<f64>,
    /// Mean amplitude over people and its standard error.
    pub amplitude: (f64, f64),
    /// Each person's amplitude and its standard deviation.
    pub personal: Vec<(f64, f64)>,
    /// Each person's variant; the first where the test of the effect tries one alone.
    pub variants: Vec<usize>,
    /// Hidden events.
    pub events: Vec<FoundEvent>,
}

impl Score {
    /// Evidence alone: the size, other variants than the first and events are the test's to fill in.
    pub(crate) fn of(effect: EffectId, test: Test, gains: Vec<f64>) -> Self {
        let variants = vec![0; gains.len()];
        let (personal, events) = (Vec::new(), Vec::new());
        Self { effect, test, gains, own: None, amplitude: (0.0, 0.0), personal, variants, events }
    }

    /// Held-out evidence of all people, nats.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.gains.iter().sum()
    }
}

/// Reads what people show before anything is named. `calibration` says which innovations are scored, and `free_runs` is
/// what a posterior reads of free runs.
///
/// # Errors
/// As [`design`](crate::design::design).
pub fn first_round(
    people: &[CalibratedPerson<'_>],
    library: &[Box<dyn Effect>],
    calibration: &CalibrationRule,
    free_runs: BTreeMap<String, f64>,
) -> Result<FirstRound, GapError> {
    let tried = Tried::of(library);
    let round = Round::of(people, &tried, &[], vec![Vec::new(); people.len()], calibration)?;
    let candidates =
        own_effects::beside_the_library(round.scores(&tried, &[]), |_| true, |_| false);
    Ok(FirstRound::of(people, &tried, &round, candidates, free_runs))
}

/// Names the effects that are missing, by the probabilities of a posterior.
///
/// `asked` is the number of people of the cohort, with those left out. An effect of the caller's own comes first where
/// it is probable beside those of the library. `calibration` says which
/// innovations are scored when a filter is run again, and `free_runs` gives what the posterior reads of free runs: those of
/// all people, or of all but the one of an index.
///
/// # Errors
/// As [`design`](crate::design::design), and [`GapError::Posterior`].
pub fn which(
    (people, asked): (&[CalibratedPerson<'_>], usize),
    library: &[Box<dyn Effect>],
    posterior: &Posterior,
    calibration: &CalibrationRule,
    free_runs: &dyn Fn(Option<usize>) -> BTreeMap<String, f64>,
) -> Result<Which, GapError> {
    let tried = Tried::of(library);
    let known = |id: EffectId| posterior.effects().iter().any(|name| name == id.name());
    let weighed = |scores| own_effects::beside_the_library(scores, known, |id| tried.is_guard(id));
    let mut round = Round::of(people, &tried, &[], vec![Vec::new(); people.len()], calibration)?;
    let mut candidates = weighed(round.scores(&tried, &[]));
    let first = FirstRound::of(people, &tried, &round, candidates.clone(), free_runs(None));
    let belief = believed(posterior, &first.statistics)?;
    let without = |person: usize| {
        let others: Vec<CalibratedPerson<'_>> = others(people, person).copied().collect();
        let rest = first_round(&others, library, calibration, free_runs(Some(person)))?;
        believed(posterior, &rest.statistics)
    };
    let withheld = on_one(&candidates, &belief, posterior, (people.len(), asked), without)?;
    let mut named: Vec<Score> = Vec::new();
    while let Some(best) = belief.next(&candidates, &withheld).cloned() {
        // Hidden events that are named change what readings weigh, and with it the information of others.
        let banks = if best.test == Test::Driven {
            round.subjects.into_iter().map(|subject| subject.events).collect()
        } else {
            vec![Vec::new(); people.len()]
        };
        named.push(best);
        round = Round::of(people, &tried, &named, banks, calibration)?;
        candidates = weighed(round.scores(&tried, &named));
    }
    let ports = round.estimated.beyond_usual.by_name();
    Ok(Which { named, withheld, first, belief, ports })
}

impl FirstRound {
    fn of(
        people: &[CalibratedPerson<'_>],
        tried: &Tried<'_>,
        round: &Round,
        candidates: Vec<Score>,
        free_runs: BTreeMap<String, f64>,
    ) -> Self {
        let days: Vec<f64> =
            people.iter().map(|p| p.observations.len() as f64 / STEPS_PER_DAY as f64).collect();
        let nobodys = |id: &EffectId| round.subjects.iter().all(|s| s.untried.contains(id));
        let untried: Vec<EffectId> = tried.ids().into_iter().filter(nobodys).collect();
        let gains = candidates.iter().map(|c| (c.effect.name().to_owned(), c.gain()));
        let gains = gains.chain(round.estimated.beyond_usual.by_name());
        let evidence = Evidence { person_days: days.iter().sum(), gains: gains.collect() };
        let spreads = round.estimated.spreads.by_name();
        let natural: Vec<&units::PersonUnits> =
            round.subjects.iter().filter_map(|s| s.natural.as_ref()).collect();
        let of_units = units::of_cohort(&natural);
        let mut statistics = statistics(people, &evidence, &spreads, &of_units);
        statistics.extend(free_runs);
        for score in &candidates {
            statistics.extend(evidence_of_people(score.effect.name(), &score.gains, &days));
        }
        let courses = units::courses(&natural);
        Self { candidates, untried, evidence, spreads, statistics, courses }
    }
}

/// What a posterior says of a cohort.
pub(crate) fn believed(
    posterior: &Posterior,
    statistics: &BTreeMap<String, f64>,
) -> Result<Belief, GapError> {
    let answer = posterior.answer(statistics).map_err(|e| GapError::Posterior(e.to_string()))?;
    Ok(Belief { answer, speaks_from: posterior.card().speaks_from })
}

/// Index of the largest of some values; 0 of none.
pub(crate) fn index_of_largest(values: &[f64]) -> usize {
    (0..values.len()).max_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rests_on_one_person_is_passed_over() {
        let of = |effect: EffectId, p: f64| (effect.name().to_owned(), p);
        let answer = posterior::Answer {
            nothing: 0.05,
            unknown: 0.1,
            effects: vec![of(EffectId::EXERCISE, 0.8), of(EffectId::DAWN, 0.6)],
            sets: Vec::new(),
            ports: Vec::new(),
            gaps: BTreeMap::new(),
        };
        let belief = Belief { answer, speaks_from: 0.7 };
        let candidates = [EffectId::EXERCISE, EffectId::DAWN]
            .map(|effect| Score::of(effect, Test::Driven, vec![9.0]));
        let named =
            |withheld: &[OnOne]| belief.next(&candidates, withheld).map(|score| score.effect);
        let one = |effect| OnOne { effect, person: 0, without: 0.1 };
        assert_eq!(named(&[]), Some(EffectId::EXERCISE));
        assert_eq!(named(&[one(EffectId::EXERCISE)]), Some(EffectId::DAWN));
        assert_eq!(named(&[one(EffectId::EXERCISE), one(EffectId::DAWN)]), None);
    }
}
