//! What is said of the effect that is named in a round.

use effects::EffectId;

use super::Named;
use super::events::EventEvidence;
use super::round::{Round, Score, ScoreOf};

impl Round {
    pub(super) fn named(&self, score: &Score, probability: f64) -> Named {
        let people = self.subjects.len();
        let (mut variants, mut events) = (vec![0; people], Vec::new());
        let (amplitude, personal) = match &score.evidence {
            ScoreOf::Driven(found) => {
                variants.clone_from(&found.variants);
                ((found.hierarchy.mean, found.hierarchy.error), found.personal.clone())
            }
            ScoreOf::Lag(found) => (found.mean, found.personal.clone()),
            ScoreOf::Events(found) => {
                events.clone_from(&found.found);
                let of = |people| self.frequency(score.effect, found, people);
                (of(0..people), (0..people).map(|person| of(person..person + 1)).collect())
            }
            ScoreOf::Random(found, log_sd) => {
                let (spread, error) = found.spread;
                let amplitude = (spread / log_sd, error / log_sd);
                (amplitude, vec![amplitude; people])
            }
        };
        Named {
            effect: score.effect,
            gain: score.gain(),
            probability,
            amplitude,
            personal,
            gains: score.gains().to_vec(),
            variants,
            events,
        }
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
}

#[cfg(test)]
mod tests {
    use effects::{EventShape, Field};

    use super::super::events::FoundEvent;
    use super::super::random_effects::UnitEvidence;
    use super::super::sample::{week, with_tried};
    use super::*;
    use crate::design::EventBank;

    #[test]
    fn a_spread_is_named_by_its_size_and_not_tried_again() {
        let round = Round::estimated(vec![week(0, 0.0), week(0, 0.0)], Vec::new());
        let random = UnitEvidence { gains: vec![5.0, 4.0], spread: (0.36, 0.09) };
        let score =
            Score { effect: EffectId::INSULIN_ABSORPTION, evidence: ScoreOf::Random(random, 0.18) };
        let named = round.named(&score, 0.7);
        assert_eq!((named.gain, named.probability), (9.0, 0.7));
        assert_eq!(named.gains, [5.0, 4.0]);
        // A spread of 0.36 where 0.18 was published.
        assert_eq!((named.amplitude, &named.personal[..]), ((2.0, 0.5), &[(2.0, 0.5); 2][..]));
        let scored = |named: &[Named]| -> Vec<EffectId> {
            let scores = with_tried(&["dawn", "insulin_absorption"], |t| round.scores(t, named));
            scores.iter().map(|score| score.effect).collect()
        };
        assert_eq!(scored(&[]), [EffectId::DAWN, EffectId::INSULIN_ABSORPTION]);
        assert_eq!(scored(&[named]), [EffectId::DAWN]);
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
        let event = |onset, size, probability| FoundEvent {
            person: 0,
            onset,
            profile: 0,
            size,
            probability,
        };
        let found = vec![event(10, 2.0, 1.0), event(500, 4.0, 0.5)];
        let evidence = EventEvidence { gains: vec![6.0, 0.0], found };
        // Two and half of four where 3.5 a week are usual; of both people 7.
        let (all, error) = round.frequency(effect, &evidence, 0..2);
        assert!((all - 4.0 / 7.0).abs() < 1e-12 && (error - 3.0 / 7.0).abs() < 1e-12);
        let score = Score { effect, evidence: ScoreOf::Events(evidence) };
        let named = round.named(&score, 0.7);
        assert_eq!(named.amplitude, (all, error));
        assert!((named.personal[0].0 - 4.0 / 3.5).abs() < 1e-12);
        assert_eq!(named.personal[1].0.to_bits(), 0.0f64.to_bits(), "not minus zero");
        assert_eq!(named.events.iter().map(|e| e.onset).collect::<Vec<_>>(), [10, 500]);
    }
}
