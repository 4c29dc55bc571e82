//! What is found, what was weighed and what could not be tried.

use crate::WithInterval;

/// Probability that an effect must exceed to be called found.
pub const FOUND_ABOVE: f64 = 0.5;
/// People whose own data must favour an effect that is called found, where there are that many.
pub const FOUND_IN: usize = 2;

/// What may be said of an effect that is named. One rule holds for one person and for many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// It is found: its probability is above [`FOUND_ABOVE`], the interval of its size lies above 0, the
    /// held-out data of [`FOUND_IN`] people favour it, where there are that many, and nothing questions it.
    Found,
    /// It is suspected: it is named, and one of the four conditions fails.
    Suspected,
}

/// An effect that is named: found or suspected, by the rule of [`FoundEffect::standing`].
#[apply(strict!)]
pub struct FoundEffect {
    /// The effect's name.
    pub effect: String,
    /// Where it enters.
    pub port: String,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
    /// The probability that it acts, with others or alone.
    pub probability: f64,
    /// Amplitude; 1 is the published size.
    pub amplitude: WithInterval,
    /// Effects that the data cannot tell from it: at least a third as probable, and not likelier than not themselves.
    pub confusable_with: Vec<String>,
    /// Every person's amplitude and evidence.
    pub people: Vec<PersonAmplitude>,
    /// Reasons to doubt the name, in sentences: where "how far" does not agree with it.
    pub questioned: Vec<String>,
}

/// An effect in one person.
#[apply(strict!)]
pub struct PersonAmplitude {
    /// The person.
    pub person_id: String,
    /// Amplitude; 1 is the published size. Drawn towards the mean of all people.
    pub amplitude: f64,
    /// Lower end of the 95 % interval.
    pub lower: f64,
    /// Upper end of the 95 % interval.
    pub upper: f64,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
}

/// An effect that could not be tried.
#[apply(strict!)]
#[derive(Eq)]
pub struct UntriedEffect {
    /// The effect's name.
    pub effect: String,
    /// What is missing.
    pub reason: String,
}

/// An effect that was tried.
#[apply(strict!)]
pub struct CandidateEffect {
    /// The effect's name.
    pub effect: String,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
    /// The probability that it acts, with others or alone.
    pub probability: f64,
    /// Why it has no name although it is probable enough; absent where there is nothing to say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_named: Option<String>,
}

impl FoundEffect {
    /// Whether it is found, or only suspected.
    #[must_use]
    pub fn standing(&self) -> Standing {
        let asked = FOUND_IN.min(self.people.len());
        let found = self.probability > FOUND_ABOVE
            && self.amplitude.lower > 0.0
            && self.in_favour() >= asked
            && self.questioned.is_empty();
        if found { Standing::Found } else { Standing::Suspected }
    }

    /// Number of people whose own held-out data favour it.
    #[must_use]
    pub fn in_favour(&self) -> usize {
        self.people.iter().filter(|person| person.gain_nats > 0.0).count()
    }

    /// Whether one of the effects that it is confusable with acts.
    #[must_use]
    pub fn set_holds(&self, acts: impl Fn(&str) -> bool) -> bool {
        self.confusable_with.iter().any(|other| acts(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn effect(probability: f64, lower: f64, gains: &[f64]) -> FoundEffect {
        let person = |gain_nats: &f64| PersonAmplitude {
            person_id: "p".to_owned(),
            amplitude: 1.0,
            lower: -0.2,
            upper: 2.0,
            gain_nats: *gain_nats,
        };
        FoundEffect {
            effect: "dawn".to_owned(),
            port: "egp".to_owned(),
            gain_nats: 9.0,
            probability,
            amplitude: WithInterval { value: 1.0, lower, upper: 2.0 },
            confusable_with: Vec::new(),
            people: gains.iter().map(person).collect(),
            questioned: Vec::new(),
        }
    }

    #[test]
    fn one_rule_says_what_is_found_for_one_person_and_for_many() {
        for (probability, lower, gains, standing) in [
            (0.97, 0.4, &[3.0][..], Standing::Found),
            (0.97, 0.4, &[], Standing::Found),
            (0.97, 0.4, &[3.0, 1.0, -1.0], Standing::Found),
            // Half is not more than half, a size may be none, and one of many is not many.
            (0.5, 0.4, &[3.0], Standing::Suspected),
            (0.97, 0.0, &[3.0], Standing::Suspected),
            (0.97, 0.4, &[3.0, -1.0, -1.0], Standing::Suspected),
            (0.97, 0.4, &[-1.0], Standing::Suspected),
        ] {
            assert_eq!(effect(probability, lower, gains).standing(), standing, "{gains:?}");
        }
        let doubted = vec!["It rests on one person.".to_owned()];
        let doubted = FoundEffect { questioned: doubted, ..effect(0.97, 0.4, &[3.0, 1.0]) };
        assert_eq!(doubted.standing(), Standing::Suspected);
    }
}
