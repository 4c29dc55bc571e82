//! What is found, what was weighed and what could not be tried.

use serde::{Deserialize, Serialize};

use crate::WithInterval;

/// An effect that was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FoundEffect {
    /// The effect's name.
    pub effect: String,
    /// Where it enters.
    pub port: String,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
    /// Probability among the candidates.
    pub probability: f64,
    /// Amplitude; 1 is the published size.
    pub amplitude: WithInterval,
    /// Effects that the data cannot tell from it.
    pub confusable_with: Vec<String>,
    /// Every person's amplitude and evidence.
    pub people: Vec<PersonAmplitude>,
    /// Reasons to doubt the name, in sentences: where "how far" does not agree with it.
    pub questioned: Vec<String>,
}

/// An effect in one person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
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

/// A size at which an effect would have been found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DetectionPower {
    /// The effect's name.
    pub effect: String,
    /// Mean absolute shift of glucose that it causes at that size in free runs of a day, mg/dL.
    pub shift_mg_dl: f64,
    /// Probability that it would have been found, if its form is that of the library and the filter's noise
    /// that of the person.
    pub power: f64,
}

/// An effect that could not be tried.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct UntriedEffect {
    /// The effect's name.
    pub effect: String,
    /// What is missing.
    pub reason: String,
}

/// An effect that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CandidateEffect {
    /// The effect's name.
    pub effect: String,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
    /// Probability among the candidates.
    pub probability: f64,
}

impl FoundEffect {
    /// Whether one of the effects that it is confusable with acts.
    #[must_use]
    pub fn set_holds(&self, acts: impl Fn(&str) -> bool) -> bool {
        self.confusable_with.iter().any(|other| acts(other))
    }
}
