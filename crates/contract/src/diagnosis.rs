//! `diagnosis.json`: where the gap lies, which effect explains it, how far it shrinks.

mod found;
mod how_far;
mod people;
mod places;

use std::collections::BTreeMap;

pub use found::{
    CandidateEffect, FOUND_ABOVE, FOUND_IN, FoundEffect, PersonAmplitude, Standing, UntriedEffect,
};
pub use how_far::{
    AmplitudeChange, HorizonChange, HorizonError, HowFar, InnovationChange, OutcomeChange,
    PersonChange,
};
pub use people::{
    CalibrationSummary, DataQualityFinding, FactorEstimate, FindingEstimate, PersonSummary,
};
pub use places::{
    CellFactor, CellGap, CoursePart, HourlyCell, HourlyGap, HourlyRow, InnovationGap, PortEvidence,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::Document;

/// A diagnosis of one plant on one cohort; `C` are the settings of who made it.
#[apply(strict!)]
pub struct Diagnosis<C = serde_json::Value> {
    /// `diagnosis/3`.
    pub schema: String,
    /// The answer.
    pub verdict: Verdict,
    /// Effects that are named, in the order in which the data were conditioned on them. One is called found where
    /// its probability is above 0.5, the interval of its amplitude lies above 0, the held-out data of two people
    /// favour it (of one, where there is one), and nothing questions it; otherwise it is called suspected.
    pub effects: Vec<FoundEffect>,
    /// Every effect that was tried; `none` and `unknown` stand among them with their probabilities.
    pub candidates: Vec<CandidateEffect>,
    /// Effects that no record could show.
    pub untried: Vec<UntriedEffect>,
    /// Evidence by place in the equations.
    pub ports: Vec<PortEvidence>,
    /// The evidence by name before any effect is conditioned on.
    pub evidence: Evidence,
    /// What the posterior said.
    pub posterior: PosteriorSaid,
    /// The gap by situation, largest share first.
    #[serde(rename = "where")]
    pub cells: Vec<CellGap>,
    /// The gap through the day, by situation and by person; missing in older files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hourly: Option<HourlyGap>,
    /// What adding the effects changes.
    pub how_far: HowFar,
    /// Errors of the calibrated plant, one entry a horizon.
    pub baseline: Vec<HorizonError>,
    /// What is doubtful about the data, by person.
    pub data_quality: Vec<DataQualityFinding>,
    /// Every person of the cohort, in its order.
    pub people: Vec<PersonSummary>,
    /// The plant that was diagnosed: `ode`, `network` or `twin`.
    pub plant: String,
    /// What has to be known to read the answer for this plant, in sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// For twins: what their residual networks have already absorbed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absorbed: Option<Absorbed>,
    /// The seed of all resampling.
    pub seed: u64,
    /// The settings.
    pub config: C,
}

impl<C: Serialize + DeserializeOwned> Document for Diagnosis<C> {
    const FILE: &'static str = "diagnosis.json";
    const SCHEMA: &'static str = "diagnosis/3";
}

/// The answer of a diagnosis.
#[apply(word!)]
pub enum Verdict {
    /// Nothing that the data could show is missing. Situations in `where` may still show errors: no
    /// plant fits a person in everything.
    None,
    /// At least one effect is named: found or suspected, see `effects`.
    Effect,
    /// Something is missing, and nothing that was tried can be named.
    Unknown,
}

/// What a posterior said of a cohort.
#[apply(strict!)]
pub struct PosteriorSaid {
    /// Probability that something is missing.
    pub something: f64,
    /// The most probable sets of effects.
    pub sets: Vec<ProbableSet>,
    /// Probability that something is missing from which on the verdict is not `none`.
    pub speaks_from: f64,
    /// Probability of an effect from which on it is named.
    pub names_from: f64,
    /// What it was trained by.
    pub source: String,
}

/// A set of effects that may act together.
#[apply(strict!)]
pub struct ProbableSet {
    /// Effects, one or more.
    pub effects: Vec<String>,
    /// Probability that these and no others act.
    pub probability: f64,
}

/// Evidence found in one cohort.
#[apply(strict!)]
#[derive(Default)]
pub struct Evidence {
    /// People times days.
    pub person_days: f64,
    /// Evidence, nats, by effect, and port with scale.
    pub gains: BTreeMap<String, f64>,
}

/// What residual networks have absorbed, all people together.
#[apply(strict!)]
pub struct Absorbed {
    /// The plant without the residual.
    pub without: String,
    /// Its verdict on the same people and days.
    pub verdict_without: Verdict,
    /// The effects named for it.
    pub found_without: Vec<String>,
    /// Evidence by effect, most before first.
    pub effects: Vec<AbsorbedEffect>,
    /// Errors of both plants, one entry a horizon.
    pub baseline: Vec<AbsorbedError>,
}

/// The evidence for an effect with both plants, before any effect is conditioned on.
#[apply(strict!)]
pub struct AbsorbedEffect {
    /// The effect.
    pub effect: String,
    /// Held-out evidence that the plant without the residual lacks it, nats.
    pub evidence_before: f64,
    /// The same with the residual, nats.
    pub evidence_after: f64,
    /// Share of the evidence that is gone; negative where it grew. `None` below 4 nats before.
    pub share: Option<f64>,
}

/// Free-run error of both plants at one horizon: mean over people, mg/dL.
#[apply(strict!)]
#[derive(Copy)]
pub struct AbsorbedError {
    /// Horizon, min.
    pub minutes: u32,
    /// Mean absolute error without the residual.
    pub mae_before: f64,
    /// Mean absolute error with it.
    pub mae_after: f64,
}
