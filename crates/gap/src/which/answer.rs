//! The answer to "which" as it is written.

use effects::{Card, Effect, EffectId};

use super::variance::SCALES;
use super::{NAMED_FROM, Score, Which};
use crate::context::hours_of_part;
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
    pub(crate) fn answer(&self, library: &[Box<dyn Effect>], people: &[&str]) -> Answer {
        let known: Vec<(&Score, Card)> =
            self.named.iter().filter_map(|n| Some((n, card(library, n.effect)?))).collect();
        let verdict = match (known.is_empty(), self.belief.alarms()) {
            (false, _) => Verdict::Effect,
            (true, true) => Verdict::Unknown,
            (true, false) => Verdict::None,
        };
        let mut candidates: Vec<CandidateEffect> = self
            .first
            .candidates
            .iter()
            .map(|candidate| CandidateEffect {
                effect: candidate.effect.name().to_owned(),
                gain_nats: candidate.gain(),
                probability: self.belief.of(candidate),
                not_named: self.why_not(candidate.effect, people),
            })
            .collect();
        let effects = known
            .iter()
            .map(|(named, card)| {
                let probability = self.belief.of(named);
                FoundEffect {
                    effect: card.id.name().to_owned(),
                    port: card.port.name().to_owned(),
                    gain_nats: named.gain(),
                    probability,
                    amplitude: interval(named.amplitude),
                    confusable_with: rivals(&candidates, probability),
                    people: amplitudes(named, people),
                    questioned: Vec::new(),
                }
            })
            .collect();
        // Effects that the posterior does not know may act beside those of the library, but where one acts something is
        // missing, and has a name.
        let own: f64 = self.first.candidates.iter().filter_map(|candidate| candidate.own).sum();
        let left = 1.0 - own.min(1.0);
        let answer = &self.belief.answer;
        for (effect, probability) in [(NONE, answer.nothing), (UNKNOWN, answer.unknown)] {
            candidates.push(CandidateEffect {
                effect: effect.to_owned(),
                gain_nats: 0.0,
                probability: left * probability,
                not_named: None,
            });
        }
        candidates.sort_by(|a, b| {
            b.probability.total_cmp(&a.probability).then(b.gain_nats.total_cmp(&a.gain_nats))
        });
        let cards = self.first.untried.iter().filter_map(|id| card(library, *id));
        let untried = cards.map(|card| {
            let channels: Vec<&str> = card.channels.iter().map(|c| c.words()).collect();
            let reason = format!("nobody's record holds what signals it: {}", channels.join(", "));
            UntriedEffect { effect: card.id.name().to_owned(), reason }
        });
        let untried = untried.collect();
        Answer { verdict, effects, candidates, ports: self.by_port(), untried }
    }

    /// Why an effect has no name although it is probable enough.
    fn why_not(&self, effect: EffectId, people: &[&str]) -> Option<String> {
        let one = self.withheld.iter().find(|one| one.effect == effect)?;
        let (person, without) = (people[one.person], 100.0 * one.without);
        Some(format!("It rests on one person: without {person} its probability is {without:.0} %."))
    }

    /// The ports as the posterior believes in them, each with the evidence of its better scale.
    fn by_port(&self) -> Vec<PortEvidence> {
        let ports = &self.belief.answer.ports;
        let gain = |name: &str| {
            let scales = SCALES.map(|scale| self.ports.get(&format!("{name}/{scale}")));
            scales.into_iter().flatten().copied().reduce(f64::max).unwrap_or(0.0)
        };
        ports
            .iter()
            .map(|(port, probability)| {
                let own = self.first.courses.iter().find(|course| course.port.name() == port);
                PortEvidence {
                    port: port.clone(),
                    gain_nats: gain(port),
                    probability: *probability,
                    confusable_with: ports
                        .iter()
                        .filter(|(other, p)| other != port && *p >= RIVAL_SHARE * probability)
                        .map(|(other, _)| other.clone())
                        .collect(),
                    // Empty where no record tells of the port.
                    unit: own.map_or_else(String::new, |course| course.unit.to_owned()),
                    course: own.map_or_else(Vec::new, parts),
                }
            })
            .collect()
    }
}

/// The course at a port as it is written.
fn parts(course: &PortCourse) -> Vec<CoursePart> {
    let part = |(part, (value, half)): (usize, &(f64, f64))| CoursePart {
        hours: hours_of_part(part),
        value: *value,
        lower: value - half,
        upper: value + half,
    };
    course.parts.iter().enumerate().map(part).collect()
}

/// The card of an effect of the library.
fn card(library: &[Box<dyn Effect>], id: EffectId) -> Option<Card> {
    library.iter().map(|effect| effect.card()).find(|card| card.id == id)
}

/// Effects that may act in the place of one that is named with this probability. What is likelier than not acts beside
/// it, named or withheld.
fn rivals(candidates: &[CandidateEffect], named: f64) -> Vec<String> {
    let probable = RIVAL_SHARE * named..NAMED_FROM;
    let rivals = candidates.iter().filter(|candidate| probable.contains(&candidate.probability));
    rivals.map(|candidate| candidate.effect.clone()).collect()
}

fn interval((value, error): (f64, f64)) -> WithInterval {
    WithInterval { value, lower: (value - Z * error).max(0.0), upper: value + Z * error }
}

fn amplitudes(named: &Score, people: &[&str]) -> Vec<PersonAmplitude> {
    people
        .iter()
        .zip(&named.personal)
        .zip(&named.gains)
        .map(|((id, amplitude), gain)| {
            let WithInterval { value, lower, upper } = interval(*amplitude);
            let (person_id, gain_nats) = ((*id).to_owned(), *gain);
            PersonAmplitude { person_id, amplitude: value, lower, upper, gain_nats }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_likelier_than_not_is_no_rival_of_a_name() {
        let candidates = [
            ("dawn", 0.9),
            ("exercise", 0.5),
            ("alcohol", 0.49),
            ("sleep_loss", 0.31),
            ("set_ageing", 0.29),
        ];
        let candidates = candidates.map(|(effect, probability)| CandidateEffect {
            effect: effect.to_owned(),
            gain_nats: 0.0,
            probability,
            not_named: None,
        });
        assert_eq!(rivals(&candidates, 0.9), ["alcohol", "sleep_loss"]);
    }

    #[test]
    fn names_of_the_output_are_not_free_and_those_of_the_library_are() {
        assert!(effects::names().into_iter().all(is_free));
        for name in ["", NONE, UNKNOWN, "egp/day", "glucose_flux/events"] {
            assert!(!is_free(name), "{name}");
        }
    }
}
