//! What a diagnosis answered: the part of `diagnosis.json` that is scored.

use serde::{Deserialize, Serialize};

/// The answer in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// There is no gap.
    None,
    /// At least one named effect acts.
    Effect,
    /// There is a gap that no named effect explains.
    Unknown,
    /// The diagnosis did not end with an answer.
    Failed,
}

/// An answer. Reads from a whole `diagnosis.json`; what is not scored is passed over.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// In one word.
    pub verdict: Verdict,
    /// Effects found, in the order of conditioning.
    #[serde(rename = "effects")]
    pub found: Vec<Found>,
    /// Every effect that was tried.
    pub candidates: Vec<Candidate>,
    /// Evidence by place in the equations.
    pub ports: Vec<PortEvidence>,
    /// The gap by hour, context, glucose band and person.
    #[serde(rename = "where", default)]
    pub cells: Vec<CellGap>,
    /// Why there is no answer, for a verdict of [`Verdict::Failed`].
    #[serde(default)]
    pub failure: Option<String>,
    /// Time that the diagnosis took, s.
    #[serde(default)]
    pub seconds: f64,
}

/// An effect that was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Its name.
    pub effect: String,
    /// Where it enters.
    pub port: String,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
    /// Probability that it acts.
    pub probability: f64,
    /// Estimate in the library's form.
    pub amplitude: Amplitude,
    /// Effects that the data cannot tell from it.
    #[serde(default)]
    pub confusable_with: Vec<String>,
}

/// An estimated amplitude with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Amplitude {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

/// An effect that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Its name, or `none` or `unknown`.
    pub effect: String,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
    /// Its probability.
    pub probability: f64,
}

/// Evidence at a port.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PortEvidence {
    /// Its name.
    pub port: String,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
    /// Its probability.
    pub probability: f64,
    /// Ports that the data cannot tell from it.
    #[serde(default)]
    pub confusable_with: Vec<String>,
    /// Unit of the course.
    #[serde(default)]
    pub unit: String,
    /// What is lacking there through the day, beyond its mean; empty where the answer states none.
    #[serde(default)]
    pub course: Vec<CoursePart>,
}

/// What is lacking at a port in a part of the day.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CoursePart {
    /// `HH-HH`.
    pub hours: String,
    /// Estimate, in the unit of the course.
    pub value: f64,
    /// Lower end of the simultaneous interval.
    pub lower: f64,
    /// Upper end of the simultaneous interval.
    pub upper: f64,
}

/// The gap in one cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CellGap {
    /// By what the cell is set apart.
    pub factor: String,
    /// Which part of it this is.
    pub level: String,
    /// Observed minus predicted, mg/dL.
    pub mean_error_mg_dl: f64,
    /// Lower end of the simultaneous interval.
    pub lower: f64,
    /// Upper end of the simultaneous interval.
    pub upper: f64,
    /// Share of the gap that the cell accounts for.
    pub share_of_gap: f64,
    /// The mean that is expected of what is missing, mg/dL; the answer's sign where it is stated.
    #[serde(default)]
    pub expected_mg_dl: Option<f64>,
    /// Length of the runs that it averages, min.
    #[serde(default)]
    pub horizon_minutes: Option<u32>,
}

impl Answer {
    /// "There is no gap", without any evidence.
    #[must_use]
    pub fn none() -> Self {
        Self {
            verdict: Verdict::None,
            found: Vec::new(),
            candidates: Vec::new(),
            ports: Vec::new(),
            cells: Vec::new(),
            failure: None,
            seconds: 0.0,
        }
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

impl Found {
    /// Whether one of the effects that it is confusable with acts.
    pub(crate) fn set_holds(&self, acts: impl Fn(&str) -> bool) -> bool {
        self.confusable_with.iter().any(|other| acts(other))
    }
}
