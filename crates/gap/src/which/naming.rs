//! What is said of the effect that is named in a round, and of the ports.

use effects::EffectId;
use rayon::prelude::*;

use super::events::EventEvidence;
use super::held_out::{self, Allowed};
use super::round::{Round, Score, ScoreOf};
use super::tried::Tried;
use super::{Candidate, Named, NamedEvent, PortCandidate, RIVAL, Thresholds, ports};

/// Correlation of two signatures, background profiled, above which the effects cannot be separated.
const SAME: f64 = 0.8;

impl Round {
    pub(super) fn named(
        &self,
        score: &Score,
        best: &Candidate,
        candidates: &[Candidate],
        tried: &Tried<'_>,
    ) -> Named {
        let people = self.subjects.len();
        let same = self.same(score, &tried.ids());
        let mut confusable = same;
        let others = candidates.iter().filter(|c| c.effect != best.effect);
        for rival in others.filter(|rival| rival.excess > 0.0) {
            if best.excess - rival.excess < RIVAL && !confusable.contains(&rival.effect) {
                confusable.push(rival.effect);
            }
        }
        let mut named = Named {
            effect: best.effect,
            gain: best.gain,
            excess: best.excess,
            amplitude: (1.0, 0.5),
            personal: vec![(1.0, 0.5); people],
            gains: vec![0.0; people],
            variants: vec![0; people],
            events: Vec::new(),
            confusable,
            rivals: candidates.to_vec(),
        };
        match &score.evidence {
            ScoreOf::Driven(found) => {
                named.amplitude = (found.hierarchy.mean, found.hierarchy.error);
                named.personal.clone_from(&found.personal);
                named.gains.clone_from(&found.gains);
                named.variants.clone_from(&found.variants);
            }
            ScoreOf::Lag(found) => {
                named.amplitude = found.mean;
                named.personal.clone_from(&found.personal);
                named.gains.clone_from(&found.gains);
            }
            ScoreOf::Events(found) => {
                let events = found.found.iter().map(|e| NamedEvent {
                    person: e.person,
                    onset: e.onset,
                    profile: e.profile,
                    size: e.size,
                });
                named.events = events.collect();
                named.gains.clone_from(&found.gains);
                named.amplitude = self.frequency(score.effect, found, 0..people);
                named.personal = (0..people)
                    .map(|person| self.frequency(score.effect, found, person..person + 1))
                    .collect();
            }
            ScoreOf::Random(found, log_sd) => {
                let (spread, error) = found.spread;
                named.amplitude = (spread / log_sd, error / log_sd);
                named.personal = vec![named.amplitude; people];
                named.gains.clone_from(&found.gains);
            }
        }
        named
    }

    /// Frequency of events of some people over the published one, and its standard error.
    pub(super) fn frequency(
        &self,
        effect: EffectId,
        found: &EventEvidence,
        people: std::ops::Range<usize>,
    ) -> (f64, f64) {
        let published = self
            .subjects
            .iter()
            .find_map(|s| s.events.iter().find(|bank| bank.effect == effect))
            .map_or(1.0, |bank| bank.shape.per_day);
        let subjects = &self.subjects[people.clone()];
        let days: usize = subjects.iter().map(|s| s.statistics.days.len()).sum();
        let theirs = found.found.iter().filter(|event| people.contains(&event.person));
        // An empty sum is -0.
        let count = theirs.map(|e| e.probability * e.size).sum::<f64>() + 0.0;
        let expected = published * days as f64;
        (count / expected, (count.sqrt() + 1.0) / expected)
    }

    /// Driven effects of `tried` whose signatures cannot be separated from that of `score`.
    pub(super) fn same(&self, score: &Score, tried: &[EffectId]) -> Vec<EffectId> {
        let ScoreOf::Driven(found) = &score.evidence else { return Vec::new() };
        let others: Vec<EffectId> =
            tried.iter().copied().filter(|id| *id != score.effect).collect();
        others
            .into_par_iter()
            .filter(|other| {
                let (mut cross, mut own, mut theirs) = (0.0, 0.0, 0.0);
                for person in 0..self.subjects.len() {
                    let mine = self.variants(person, score.effect);
                    let rival = self.variants(person, *other);
                    let Some(mine) = mine.get(found.variants[person]) else { continue };
                    let allowed: Vec<Allowed> = self
                        .allowed(person, None)
                        .into_iter()
                        .filter(|a| !rival.contains(&a.column))
                        .collect();
                    let best = rival
                        .iter()
                        .map(|r| held_out::profiled(&self.marginal[person], &allowed, *mine, *r))
                        .max_by(|a, b| a.correlation().total_cmp(&b.correlation()));
                    if let Some(best) = best {
                        cross += best.cross;
                        own += best.own;
                        theirs += best.other;
                    }
                }
                own > 0.0 && theirs > 0.0 && cross / (own * theirs).sqrt() > SAME
            })
            .collect()
    }

    pub(super) fn ports(&self, thresholds: &Thresholds, person_days: f64) -> Vec<PortCandidate> {
        let mut ports: Vec<PortCandidate> = ports::gains(&self.estimated)
            .into_iter()
            .map(|found| {
                let name = ports::threshold_name(found.port, found.within_days);
                let threshold = thresholds.of(&name).over(person_days);
                PortCandidate {
                    port: found.port,
                    gain: found.gain,
                    excess: found.gain - threshold,
                    within_days: found.within_days,
                }
            })
            .collect();
        ports.sort_by(|a, b| b.excess.total_cmp(&a.excess));
        ports
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use effects::{EventShape, Field};

    use super::super::events::Found;
    use super::super::random_effects::UnitEvidence;
    use super::super::sample::{self, COLUMNS, DAWN, EXERCISE, week, with_tried};
    use super::super::{Threshold, ThresholdStep};
    use super::*;
    use crate::design::EventBank;

    const NAMES: [&str; 3] = ["dawn", "exercise", "renal_threshold"];

    fn candidate(effect: EffectId, excess: f64) -> Candidate {
        Candidate { effect, gain: excess + 4.0, excess }
    }

    #[test]
    fn a_rival_that_clears_its_threshold_by_nearly_as_much_is_confusable() {
        let round = Round::estimated(vec![week(0, 0.0), week(0, 0.0)], Vec::new());
        let random = UnitEvidence { gains: vec![5.0, 4.0], spread: (0.36, 0.09) };
        let score =
            Score { effect: EffectId::INSULIN_ABSORPTION, evidence: ScoreOf::Random(random, 0.18) };
        let near = candidate(EffectId::DAWN, 5.0 - 0.9 * RIVAL);
        let far = candidate(EffectId::EXERCISE, 5.0 - 1.1 * RIVAL);
        let none = candidate(EffectId::RENAL_THRESHOLD, 0.0);
        let all = [candidate(EffectId::INSULIN_ABSORPTION, 5.0), near, far, none];
        let named = with_tried(&NAMES, |tried| round.named(&score, &all[0], &all, tried));
        assert_eq!(named.confusable, [EffectId::DAWN]);
        assert_eq!(named.gains, [5.0, 4.0]);
        // A spread of 0.36 where 0.18 was published.
        assert_eq!((named.amplitude, &named.personal[..]), ((2.0, 0.5), &[(2.0, 0.5); 2][..]));
        // What is named is not tried again.
        let scored = |named: &[Named]| -> Vec<EffectId> {
            let scores = with_tried(&["dawn", "insulin_absorption"], |t| round.scores(t, named));
            scores.iter().map(|score| score.effect).collect()
        };
        assert_eq!(scored(&[]), [EffectId::DAWN, EffectId::INSULIN_ABSORPTION]);
        assert_eq!(scored(&[named]), [EffectId::DAWN]);
    }

    fn named_of(round: &Round, score: &Score) -> Named {
        let best = candidate(score.effect, 1.0);
        with_tried(&NAMES, |tried| round.named(score, &best, &[], tried))
    }

    #[test]
    fn the_frequency_is_what_events_add_up_to_over_what_was_published() {
        let shape = EventShape {
            field: Field::ExtraCarbs,
            profiles: vec![vec![30.0]],
            onsets: Vec::new(),
            per_day: 0.5,
            sizes: vec![(1.0, 1.0)],
        };
        let effect = EffectId::MISSED_MEALS;
        let mut people = vec![week(0, 0.0), week(0, 0.0)];
        let (onsets, known) = (Vec::new(), Vec::new());
        people[0].events.push(EventBank { effect, shape, onsets, known });
        let round = Round::estimated(people, Vec::new());
        let event =
            |onset, size, probability| Found { person: 0, onset, profile: 0, size, probability };
        let found = vec![event(10, 2.0, 1.0), event(500, 4.0, 0.5)];
        let evidence = EventEvidence { gains: vec![6.0, 0.0], found };
        // Two and half of four where 3.5 a week are usual; of both people 7.
        let (all, error) = round.frequency(effect, &evidence, 0..2);
        assert!((all - 4.0 / 7.0).abs() < 1e-12 && (error - 3.0 / 7.0).abs() < 1e-12);
        let score = Score { effect, evidence: ScoreOf::Events(evidence) };
        let named = named_of(&round, &score);
        assert_eq!(named.amplitude, (all, error));
        assert!((named.personal[0].0 - 4.0 / 3.5).abs() < 1e-12);
        assert_eq!(named.personal[1].0.to_bits(), 0.0f64.to_bits(), "not minus zero");
        assert_eq!(named.events.iter().map(|e| e.onset).collect::<Vec<_>>(), [10, 500]);
    }

    #[test]
    fn effects_whose_signatures_correlate_cannot_be_separated() {
        // Exercise does what dawn does and `own` in steps of its own: a correlation of 1 / sqrt(1 + own^2).
        for (own, expected) in [(0.7, true), (0.8, false)] {
            let mut design = sample::design(sample::only(DAWN[0], 1.0), &[0.0; 7]);
            for (step, value) in design.signatures[EXERCISE].iter_mut().enumerate() {
                *value = match step % COLUMNS {
                    column if column == DAWN[0] => 1.0,
                    EXERCISE => own,
                    _ => 0.0,
                };
            }
            let round = Round::estimated(vec![sample::subject(design)], Vec::new());
            let same = with_tried(&NAMES, |tried| {
                let scores = round.scores(tried, &[]);
                let dawn = scores.iter().find(|score| score.effect == EffectId::DAWN);
                round.same(dawn.expect("scored"), &tried.ids())
            });
            assert_eq!(same == [EffectId::EXERCISE], expected, "{own}: {same:?}");
        }
    }

    #[test]
    fn ports_come_in_the_order_of_what_they_exceed_their_thresholds_by() {
        let mut round = Round::estimated(Vec::new(), Vec::new());
        round.estimated.day[1].beyond_usual = 27.0;
        round.estimated.block[2].beyond_usual = 29.0;
        let threshold =
            |nats| Threshold { steps: vec![ThresholdStep { person_days: 100.0, nats }] };
        let best = ports::threshold_name(effects::Port::GutAbsorption, true);
        let thresholds = Thresholds::from(contract::Thresholds {
            source: String::new(),
            by_name: BTreeMap::from([(best, threshold(28.0))]),
            other: threshold(25.0),
            temperature: 1.0,
        });
        let found = round.ports(&thresholds, 50.0);
        let first = |k: usize| (found[k].port, found[k].excess, found[k].within_days);
        assert_eq!(first(0), (effects::Port::Egp, 2.0, false));
        assert_eq!(first(1), (effects::Port::GutAbsorption, 1.0, true));
        assert!(found[2..].iter().all(|port| port.excess == -25.0));
    }
}
