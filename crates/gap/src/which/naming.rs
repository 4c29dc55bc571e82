//! What is said of the effect that is named in a round, and of the ports.

use effects::EffectId;
use rayon::prelude::*;

use super::events::EventEvidence;
use super::held_out::{self, Allowed};
use super::round::{Round, Score, ScoreOf};
use super::tried::Tried;
use super::{Candidate, Named, NamedEvent, PortCandidate, RIVAL, Thresholds, ports};

/// Correlation of two signatures, background profiled, above which the effects cannot be told apart.
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
