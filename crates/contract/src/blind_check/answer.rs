//! What a diagnosis answered: the part that is scored.

use crate::diagnosis::{CandidateEffect, CellGap, FoundEffect, PortEvidence};

/// The answer in one word.
#[apply(word!)]
#[derive(Default, Hash)]
pub enum Verdict {
    /// There is no gap.
    #[default]
    None,
    /// At least one named effect acts.
    Effect,
    /// There is a gap that no named effect explains.
    Unknown,
    /// The diagnosis did not end with an answer.
    Failed,
}

/// What is scored of a diagnosis; the file of a world whose diagnosis failed. Others have a `diagnosis.json` there.
#[apply(strict!)]
#[derive(Default)]
pub struct Answer {
    /// In one word.
    pub verdict: Verdict,
    /// Effects found, in the order of conditioning.
    #[serde(rename = "effects")]
    pub found: Vec<FoundEffect>,
    /// Every effect that was tried.
    pub candidates: Vec<CandidateEffect>,
    /// Evidence by place in the equations.
    pub ports: Vec<PortEvidence>,
    /// The gap by hour, context, glucose band and person.
    #[serde(rename = "where")]
    pub cells: Vec<CellGap>,
    /// Why there is no answer, for a verdict of [`Verdict::Failed`].
    pub failure: Option<String>,
    /// Time that the diagnosis took, s.
    pub seconds: f64,
}

/// How the answer for one world compares with its label.
///
/// What is right depends on the kind of world: "none" for a null world, all effects and no other
/// for one or two effects, "unknown" for an effect outside the library.
#[apply(word!)]
#[derive(Hash)]
pub enum Outcome {
    /// Right, and nothing besides.
    Correct,
    /// Every effect is named, and one that does not act as well.
    WithExtra,
    /// One of two effects is named.
    Partial,
    /// No effect is named, but one of them stands in the set of those that an effect that is named
    /// cannot be told from.
    InSet,
    /// An effect is named that does not act, and none that does.
    Wrong,
    /// "Unknown" where that is not right.
    Unknown,
    /// "None" where something acts.
    Missed,
    /// No answer.
    Failed,
}

impl Answer {
    /// Whether it says that something is missing, by name or not. A diagnosis that failed says nothing.
    #[must_use]
    pub fn raises_alarm(&self) -> bool {
        matches!(self.verdict, Verdict::Effect | Verdict::Unknown)
    }

    /// "There is no gap", without any evidence.
    #[must_use]
    pub fn none() -> Self {
        Self::default()
    }

    /// The answer of a diagnosis that did not end with one.
    #[must_use]
    pub fn failed(reason: impl Into<String>, seconds: f64) -> Self {
        Self { verdict: Verdict::Failed, failure: Some(reason.into()), seconds, ..Self::none() }
    }

    /// The effect that comes first, if any is named.
    #[must_use]
    pub fn first(&self) -> Option<&str> {
        self.found.first().map(|found| found.effect.as_str())
    }

    /// The port with the strongest evidence.
    #[must_use]
    pub fn best_port(&self) -> Option<&PortEvidence> {
        self.ports.iter().max_by(|a, b| {
            a.probability.total_cmp(&b.probability).then(a.gain_nats.total_cmp(&b.gain_nats))
        })
    }

    /// Probability that the diagnosis gives to its own answer, if it states one.
    #[must_use]
    pub fn probability_of_verdict(&self) -> Option<f64> {
        let named =
            |name: &str| self.candidates.iter().find(|c| c.effect == name).map(|c| c.probability);
        match self.verdict {
            Verdict::None => named("none"),
            Verdict::Unknown => named("unknown"),
            Verdict::Effect | Verdict::Failed => None,
        }
    }
}

impl Outcome {
    /// Whether it is right, or the truth stands in the set that the answer offers.
    #[must_use]
    pub const fn is_correct_or_in_set(self) -> bool {
        matches!(self, Self::Correct | Self::InSet)
    }
}
