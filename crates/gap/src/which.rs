//! Which effect is missing: candidates against the background, one after the other.
//!
//! Every effect of the library is tested by held-out evidence on the linear model of the innovations
//! ([`design`](crate::design)), with the background profiled and random differences between days integrated
//! out. The effect that exceeds its threshold by most is named. The plant is then run again with it, and
//! the others are tested on what is left. Where nothing is named and a port varies by more than it does in
//! anybody, the answer is "unknown".

mod amplitude;
mod answer;
mod backgrounds;
pub mod ceiling;
mod conditioned;
mod detection;
mod events;
mod folds;
mod held_out;
mod lag;
mod naming;
mod ports;
mod random_effects;
mod round;
mod round_person;
#[cfg(test)]
mod sample;
mod scores;
mod statistics;
mod thresholds;
mod tried;
mod variance;

use contract::diagnosis::Evidence;
use std::collections::BTreeMap;

use effects::{Effect, EffectId, Port};
use posterior::Posterior;

use self::round::{Round, Score, ScoreOf};
use self::tried::Tried;
use crate::calibrated_person::CalibratedPerson;
use crate::cohort_statistics::{evidence_of_people, statistics};
use crate::error::GapError;
use crate::filter::calibration::CalibrationRule;
use crate::units::{self, PortCourse};

pub(crate) use self::answer::is_free;
pub(crate) use self::detection::power;
pub use self::thresholds::{Threshold, ThresholdStep, Thresholds};

/// Most effects that are named.
const MOST_EFFECTS: usize = 3;
/// How much more evidence an effect must show beside one that is named: what the first leaves unexplained, in form
/// or in people, looks like another effect.
const LATER: f64 = 1.5;
/// Nats within which a rival that clears its threshold is no worse an answer.
const RIVAL: f64 = 3.0;
/// The answer to "which".
#[derive(Debug, Clone)]
pub struct Which {
    /// The effects named, in the order of conditioning.
    pub named: Vec<Named>,
    /// Every effect that was tried, at the first round.
    pub candidates: Vec<Candidate>,
    /// Evidence by port and scale, once the named effects are conditioned on.
    pub ports: Vec<PortCandidate>,
    /// Effects that no record could show.
    pub untried: Vec<EffectId>,
    /// People times days.
    pub person_days: f64,
    /// The evidence of the first round by name.
    pub evidence: Evidence,
    /// Spreads of the random factors at the first round, log or relative, by port: `egp/day`, `egp/block` and so on.
    pub spreads: BTreeMap<String, f64>,
    /// What the first round would have found of each driven effect.
    pub detectable: Vec<Detectable>,
    /// What a posterior reads of the cohort.
    pub statistics: BTreeMap<String, f64>,
    /// What the posterior says of them; `None` where thresholds decided.
    pub belief: Option<Belief>,
    /// What is lacking at the ports through the day.
    pub(crate) courses: Vec<PortCourse>,
}

/// Probability from which on an effect is named where something is missing: it is more likely there than not.
pub(crate) const NAMED_FROM: f64 = 0.5;
/// Probability from which on something is said to be missing, with a name or without: odds of 3 to 1, as a false alarm
/// costs more than silence.
pub(crate) const SAID_FROM: f64 = 0.75;

/// What a posterior says.
#[derive(Debug, Clone, PartialEq)]
pub struct Belief {
    /// Its probabilities.
    pub answer: posterior::Answer,
}

impl Belief {
    /// The next to be named: an effect that the posterior does not know and that clears its threshold, or else the most
    /// probable that is left of those that it knows.
    fn next<'a>(&self, candidates: &'a [Candidate], named: &[Named]) -> Option<&'a Candidate> {
        let open = candidates.iter().filter_map(|candidate| {
            let id = candidate.effect;
            named.iter().all(|n| n.effect != id).then_some((candidate, id))
        });
        let own = open.clone().find(|(candidate, id)| !self.knows(*id) && candidate.excess > 0.0);
        let known =
            open.filter(|(_, id)| self.alarms() && self.knows(*id) && self.of(*id) >= NAMED_FROM);
        let best = known.max_by(|a, b| self.of(a.1).total_cmp(&self.of(b.1)));
        own.or(best).map(|(candidate, _)| candidate)
    }

    /// The probability of an effect; 0 of one that the posterior does not know.
    pub(crate) fn of(&self, id: EffectId) -> f64 {
        let own = self.answer.effects.iter().find(|(name, _)| name == id.name());
        own.map_or(0.0, |(_, p)| *p)
    }

    /// Whether the posterior knows an effect.
    pub(crate) fn knows(&self, id: EffectId) -> bool {
        self.answer.effects.iter().any(|(name, _)| name == id.name())
    }

    /// Whether something is said to be missing.
    pub(crate) fn alarms(&self) -> bool {
        1.0 - self.answer.nothing >= SAID_FROM
    }
}

/// The size of an effect that would have been found with 90 % probability.
#[derive(Debug, Clone)]
pub struct Detectable {
    /// The effect.
    pub effect: EffectId,
    /// Its amplitude.
    pub amplitude: f64,
    /// Each person's variant.
    pub variants: Vec<usize>,
}

/// What was tried.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Which effect.
    pub effect: EffectId,
    /// Held-out evidence, nats.
    pub gain: f64,
    /// Evidence over the threshold, nats.
    pub excess: f64,
}

/// A port that was tried.
#[derive(Debug, Clone, Copy)]
pub struct PortCandidate {
    /// The port.
    pub port: Port,
    /// Evidence, nats.
    pub gain: f64,
    /// Evidence over the threshold, nats.
    pub excess: f64,
    /// Whether it varies within days rather than between them.
    pub within_days: bool,
}

/// What was named.
#[derive(Debug, Clone)]
pub struct Named {
    /// Which effect.
    pub effect: EffectId,
    /// Held-out evidence in the round in which it was named, nats.
    pub gain: f64,
    /// Evidence over the threshold, nats.
    pub excess: f64,
    /// Mean amplitude over people and its standard error.
    pub amplitude: (f64, f64),
    /// Each person's amplitude and its standard deviation.
    pub personal: Vec<(f64, f64)>,
    /// Each person's gain, nats.
    pub gains: Vec<f64>,
    /// Each person's variant.
    pub variants: Vec<usize>,
    /// Hidden events.
    pub events: Vec<NamedEvent>,
    /// What cannot be separated from it.
    pub confusable: Vec<EffectId>,
    /// Candidates of its round.
    pub rivals: Vec<Candidate>,
}

/// A hidden event of an effect that was named.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NamedEvent {
    /// The person's index.
    pub person: usize,
    /// Step of its onset.
    pub onset: usize,
    /// Which of the effect's profiles it has.
    pub profile: usize,
    /// Its size relative to the published.
    pub size: f64,
}

/// Names the effects that are missing. `calibration` says which innovations are scored when a filter is run again, and
/// `free_runs` is what a posterior reads of free runs.
///
/// With a posterior, its probabilities decide about the effects that it knows, and thresholds about the others: an effect
/// of the caller's own that clears its threshold comes first. Without one, thresholds decide about all.
///
/// # Errors
/// As [`design`](crate::design::design), and [`GapError::Posterior`].
pub fn which(
    people: &[CalibratedPerson<'_>],
    library: &[Box<dyn Effect>],
    thresholds: &Thresholds,
    posterior: Option<&Posterior>,
    calibration: &CalibrationRule,
    mut free_runs: BTreeMap<String, f64>,
) -> Result<Which, GapError> {
    let tried = Tried::of(library);
    let days: Vec<f64> = people
        .iter()
        .map(|p| p.observations.len() as f64 / physiology::STEPS_PER_DAY as f64)
        .collect();
    let person_days: f64 = days.iter().sum();
    let mut named: Vec<Named> = Vec::new();
    let mut first: Option<First> = None;
    let mut banks = vec![Vec::new(); people.len()];
    loop {
        let round = Round::of(people, &tried, &named, banks, calibration)?;
        let scores = round.scores(&tried, &named);
        let mut candidates: Vec<Candidate> = scores
            .iter()
            .map(|score| {
                let effect = score.effect;
                let threshold = thresholds.of_effect(&tried.get(effect).card(), tried.effects());
                let needed =
                    if named.is_empty() { 1.0 } else { LATER } * threshold.over(person_days);
                let gain = score.gain();
                let excess = gain - needed;
                // Once something is named, what is left shows in how glucose is shed and defended.
                let left = !named.is_empty() && tried.is_guard(effect);
                Candidate { effect, gain, excess: if left { excess.min(0.0) } else { excess } }
            })
            .collect();
        candidates.sort_by(|a, b| b.excess.total_cmp(&a.excess));
        let nobodys = |id: &EffectId| round.subjects.iter().all(|s| s.design.untried.contains(id));
        let library = tried.effects().iter().map(|effect| effect.card().id);
        let untried: Vec<EffectId> = library.filter(nobodys).collect();
        let evidence = || {
            let of_port =
                |p: ports::PortGain| (ports::threshold_name(p.port, p.within_days), p.gain);
            let gains = candidates.iter().map(|c| (c.effect.name().to_owned(), c.gain));
            let gains = gains.chain(ports::gains(&round.estimated).into_iter().map(of_port));
            Evidence { person_days, gains: gains.collect() }
        };
        let found = match first.take() {
            Some(found) => found,
            None => {
                let (evidence, spreads) = (evidence(), round.estimated.spreads.by_name());
                let natural: Vec<&units::PersonUnits> =
                    round.subjects.iter().filter_map(|s| s.natural.as_ref()).collect();
                let of_units = units::of_cohort(&natural);
                let mut statistics = statistics(people, &evidence, &spreads, &of_units);
                statistics.append(&mut free_runs);
                statistics.extend(scores.iter().flat_map(|score| {
                    evidence_of_people(score.effect.name(), score.gains(), &days)
                }));
                First {
                    courses: units::courses(&natural),
                    candidates: candidates.clone(),
                    untried,
                    evidence,
                    spreads,
                    detectable: detectable(&scores, &tried, thresholds, person_days),
                    belief: posterior.map(|p| believed(p, &statistics)).transpose()?,
                    statistics,
                }
            }
        };
        let found = first.insert(found);
        let best = match &found.belief {
            Some(belief) => belief.next(&candidates, &named),
            None => candidates.first().filter(|best| best.excess > 0.0),
        };
        let best = best.filter(|_| named.len() < MOST_EFFECTS);
        let Some(best) = best else {
            let ports = round.ports(thresholds, person_days);
            let First {
                candidates,
                untried,
                evidence,
                spreads,
                detectable,
                statistics,
                belief,
                courses,
            } = found.clone();
            return Ok(Which {
                courses,
                named,
                candidates,
                ports,
                untried,
                person_days,
                evidence,
                spreads,
                detectable,
                statistics,
                belief,
            });
        };
        let score = scores
            .iter()
            .find(|score| score.effect == best.effect)
            .expect("a candidate comes from a score");
        named.push(round.named(score, best, &candidates, &tried));
        // Hidden events that are named change what readings weigh, and with it the information of others.
        banks = if matches!(score.evidence, ScoreOf::Driven(_)) {
            round.subjects.into_iter().map(|subject| subject.events).collect()
        } else {
            vec![Vec::new(); people.len()]
        };
    }
}

/// What is kept of the first round.
#[derive(Clone)]
struct First {
    candidates: Vec<Candidate>,
    untried: Vec<EffectId>,
    evidence: Evidence,
    spreads: BTreeMap<String, f64>,
    detectable: Vec<Detectable>,
    statistics: BTreeMap<String, f64>,
    belief: Option<Belief>,
    courses: Vec<PortCourse>,
}

/// What a posterior says of a cohort.
pub(crate) fn believed(
    posterior: &Posterior,
    statistics: &BTreeMap<String, f64>,
) -> Result<Belief, GapError> {
    let answer = posterior.answer(statistics).map_err(|e| GapError::Posterior(e.to_string()))?;
    Ok(Belief { answer })
}

/// What a round would have found of each driven effect.
fn detectable(
    scores: &[Score],
    tried: &Tried<'_>,
    thresholds: &Thresholds,
    person_days: f64,
) -> Vec<Detectable> {
    scores
        .iter()
        .filter_map(|score| {
            let effect = score.effect;
            let ScoreOf::Driven(found) = &score.evidence else { return None };
            let threshold =
                thresholds.of_effect(&tried.get(effect).card(), tried.effects()).over(person_days);
            Some(Detectable {
                effect,
                amplitude: detection::amplitude(found.information, threshold)?,
                variants: found.variants.clone(),
            })
        })
        .collect()
}
