//! The answer to "which" as it is written.

use effects::{Card, Effect, EffectId};

use super::ports::alike;
use super::{Belief, Candidate, Named, PortCandidate, RIVAL, Which};
use crate::context::hours_of_part;
use crate::log_sum::softmax_beside_none;
use crate::units::PortCourse;
use contract::WithInterval;
use contract::diagnosis::{
    CandidateEffect, CoursePart, FoundEffect, PersonAmplitude, PortEvidence, UntriedEffect, Verdict,
};

/// Name of the candidate that nothing is missing.
const NONE: &str = "none";
/// Name of the candidate that something is missing that the library does not hold.
const UNKNOWN: &str = "unknown";
/// Share of a named effect's probability from which on another effect is a rival.
const RIVAL_SHARE: f64 = 1.0 / 3.0;
/// Half width of a 95 % interval in standard errors.
const Z: f64 = 1.96;

/// Whether an effect may have this name: it stands for nothing else in the output.
pub(crate) fn is_free(name: &str) -> bool {
    let taken = name.is_empty() || name == NONE || name == UNKNOWN;
    !taken && !name.contains('/')
}

/// What a diagnosis says about the effects.
pub(crate) struct Answer {
    pub(crate) verdict: Verdict,
    pub(crate) effects: Vec<FoundEffect>,
    pub(crate) candidates: Vec<CandidateEffect>,
    pub(crate) ports: Vec<PortEvidence>,
    pub(crate) untried: Vec<UntriedEffect>,
}

impl Which {
    /// The answer in words and numbers. `people` names the people in the order of the analysis.
    pub(crate) fn answer(
        &self,
        library: &[Box<dyn Effect>],
        people: &[&str],
        temperature: f64,
    ) -> Answer {
        let known: Vec<(&Named, Card)> =
            self.named.iter().filter_map(|n| Some((n, card(library, n.effect)?))).collect();
        let unknown_port = self.ports.iter().any(|port| port.excess > 0.0);
        let something = match &self.belief {
            Some(belief) => belief.alarms(),
            None => unknown_port,
        };
        let verdict = match (known.is_empty(), something) {
            (false, _) => Verdict::Effect,
            (true, true) => Verdict::Unknown,
            (true, false) => Verdict::None,
        };
        let first = match &self.belief {
            Some(belief) => Odds::believed(belief, &self.candidates, temperature),
            None => Odds::of(&self.candidates, &self.ports, temperature),
        };
        let effects = known
            .iter()
            .map(|(named, card)| {
                let is_first = |first: &Named| first.effect == named.effect;
                let ports =
                    if self.named.first().is_some_and(is_first) { &*self.ports } else { &[] };
                let probability = match self.belief {
                    Some(_) => first.of_effect(card.id),
                    None => Odds::of(&named.rivals, ports, temperature).of_effect(card.id),
                };
                FoundEffect {
                    effect: card.id.name().to_owned(),
                    port: card.port.name().to_owned(),
                    gain_nats: named.gain,
                    probability,
                    amplitude: interval(named.amplitude),
                    confusable_with: self.confusable(named, probability, &first),
                    people: amplitudes(named, people),
                    questioned: Vec::new(),
                }
            })
            .collect();
        let mut candidates: Vec<CandidateEffect> = self
            .candidates
            .iter()
            .map(|candidate| CandidateEffect {
                effect: candidate.effect.name().to_owned(),
                gain_nats: candidate.gain,
                probability: first.of_effect(candidate.effect),
            })
            .collect();
        for (effect, probability) in [(NONE, first.none), (UNKNOWN, first.unknown)] {
            let effect = effect.to_owned();
            candidates.push(CandidateEffect { effect, gain_nats: 0.0, probability });
        }
        candidates.sort_by(|a, b| {
            b.probability.total_cmp(&a.probability).then(b.gain_nats.total_cmp(&a.gain_nats))
        });
        let untried = self
            .untried
            .iter()
            .filter_map(|id| card(library, *id))
            .map(|card| {
                let channels: Vec<&str> = card.channels.iter().map(|c| c.words()).collect();
                UntriedEffect {
                    effect: card.id.name().to_owned(),
                    reason: format!(
                        "nobody's record holds what signals it: {}",
                        channels.join(", ")
                    ),
                }
            })
            .collect();
        Answer { verdict, effects, candidates, ports: self.by_port(temperature), untried }
    }

    /// Effects that the data cannot tell from a named one.
    fn confusable(&self, named: &Named, probability: f64, odds: &Odds) -> Vec<String> {
        let ids: Vec<EffectId> = match self.belief {
            Some(_) => {
                let rivals = odds.effects.iter().filter(|(id, p)| {
                    *p >= RIVAL_SHARE * probability && self.named.iter().all(|n| n.effect != *id)
                });
                rivals.map(|(id, _)| *id).collect()
            }
            None => named.confusable.clone(),
        };
        ids.into_iter().map(|id| id.name().to_owned()).collect()
    }

    /// The better scale of each port.
    fn by_port(&self, temperature: f64) -> Vec<PortEvidence> {
        let mut best: Vec<(effects::Port, f64, f64)> = Vec::new();
        for (port, gain, excess) in self.ports.iter().map(|p| (p.port, p.gain, p.excess)) {
            match best.iter_mut().find(|(known, _, _)| *known == port) {
                Some(entry) if entry.2 < excess => *entry = (port, gain, excess),
                Some(_) => {}
                None => best.push((port, gain, excess)),
            }
        }
        let excess: Vec<f64> = best.iter().map(|(_, _, excess)| *excess).collect();
        let (_, shares) = softmax_beside_none(&excess, temperature);
        if let Some(belief) = &self.belief {
            return believed_ports(belief, &best, &self.courses);
        }
        let mut ports: Vec<PortEvidence> = best
            .iter()
            .zip(&shares)
            .map(|((port, gain, excess), share)| PortEvidence {
                port: port.name().to_owned(),
                gain_nats: *gain,
                probability: *share,
                confusable_with: best
                    .iter()
                    .filter(|(_, rival, above)| {
                        *excess > 0.0 && *above > 0.0 && (gain - rival).abs() < RIVAL
                    })
                    .map(|(other, _, _)| *other)
                    .filter(|other| other != port && !alike(*port).any(|a| a == *other))
                    .chain(alike(*port))
                    .map(|other| other.name().to_owned())
                    .collect(),
                unit: unit_of(port.name(), &self.courses),
                course: course_of(port.name(), &self.courses),
            })
            .collect();
        ports.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        ports
    }
}

/// The ports as a posterior believes in them, with the evidence that there is of each.
fn believed_ports(
    belief: &Belief,
    evidence: &[(effects::Port, f64, f64)],
    courses: &[PortCourse],
) -> Vec<PortEvidence> {
    let ports = &belief.answer.ports;
    let gain = |name: &str| evidence.iter().find(|(port, ..)| port.name() == name).map(|e| e.1);
    ports
        .iter()
        .map(|(port, probability)| PortEvidence {
            port: port.clone(),
            gain_nats: gain(port).unwrap_or(0.0),
            probability: *probability,
            confusable_with: ports
                .iter()
                .filter(|(other, p)| other != port && *p >= RIVAL_SHARE * probability)
                .map(|(other, _)| other.clone())
                .collect(),
            unit: unit_of(port, courses),
            course: course_of(port, courses),
        })
        .collect()
}

/// The course at a port as it is written; empty where no record tells of it.
fn course_of(port: &str, courses: &[PortCourse]) -> Vec<CoursePart> {
    let own = courses.iter().find(|course| course.port.name() == port);
    let parts = own.iter().flat_map(|course| course.parts.iter().enumerate());
    let part = |(part, (value, half)): (usize, &(f64, f64))| CoursePart {
        hours: hours_of_part(part),
        value: *value,
        lower: value - half,
        upper: value + half,
    };
    parts.map(part).collect()
}

fn unit_of(port: &str, courses: &[PortCourse]) -> String {
    let own = courses.iter().find(|course| course.port.name() == port);
    own.map_or_else(String::new, |course| course.unit.to_owned())
}

/// The card of an effect of the library.
fn card(library: &[Box<dyn Effect>], id: EffectId) -> Option<Card> {
    library.iter().map(|effect| effect.card()).find(|card| card.id == id)
}

/// Probabilities of the answers of one round.
struct Odds {
    none: f64,
    unknown: f64,
    effects: Vec<(EffectId, f64)>,
}

impl Odds {
    /// A softmax of the evidence over the thresholds, "none" and "unknown" in it.
    fn of(candidates: &[Candidate], ports: &[PortCandidate], temperature: f64) -> Self {
        let unknown = ports.iter().map(|p| p.excess).fold(f64::NEG_INFINITY, f64::max);
        let effects: Vec<(EffectId, f64)> =
            candidates.iter().map(|c| (c.effect, c.excess)).collect();
        let excess: Vec<f64> =
            effects.iter().map(|(_, excess)| *excess).chain(std::iter::once(unknown)).collect();
        let (none, shares) = softmax_beside_none(&excess, temperature);
        Self {
            none,
            unknown: shares[effects.len()],
            effects: effects.iter().zip(&shares).map(|((id, _), share)| (*id, *share)).collect(),
        }
    }

    /// What a posterior says; of effects that it does not know, what the evidence does.
    fn believed(belief: &Belief, candidates: &[Candidate], temperature: f64) -> Self {
        let by_evidence = Self::of(candidates, &[], temperature);
        let of =
            |id: EffectId| if belief.knows(id) { belief.of(id) } else { by_evidence.of_effect(id) };
        let own: f64 =
            by_evidence.effects.iter().filter(|(id, _)| !belief.knows(*id)).map(|(_, p)| p).sum();
        let left = 1.0 - own.min(1.0);
        let effects = by_evidence
            .effects
            .iter()
            .map(|(id, _)| (*id, if belief.knows(*id) { left * of(*id) } else { of(*id) }))
            .collect();
        Self { none: left * belief.answer.nothing, unknown: left * belief.answer.unknown, effects }
    }

    fn of_effect(&self, effect: EffectId) -> f64 {
        self.effects.iter().find(|(id, _)| *id == effect).map_or(0.0, |(_, p)| *p)
    }
}

fn interval((value, error): (f64, f64)) -> WithInterval {
    WithInterval { value, lower: (value - Z * error).max(0.0), upper: value + Z * error }
}

fn amplitudes(named: &Named, people: &[&str]) -> Vec<PersonAmplitude> {
    people
        .iter()
        .zip(&named.personal)
        .zip(&named.gains)
        .map(|((id, amplitude), gain)| {
            let with_interval = interval(*amplitude);
            PersonAmplitude {
                person_id: (*id).to_owned(),
                amplitude: with_interval.value,
                lower: with_interval.lower,
                upper: with_interval.upper,
                gain_nats: *gain,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_output_are_not_free_and_those_of_the_library_are() {
        assert!(effects::names().into_iter().all(is_free));
        for name in ["", NONE, UNKNOWN, "egp/day", "glucose_flux/events"] {
            assert!(!is_free(name), "{name}");
        }
    }
}
