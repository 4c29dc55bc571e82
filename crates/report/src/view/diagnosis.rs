//! `diagnosis.json`: where the gap lies, which effect explains it, how far it shrinks.

use serde::Deserialize;

use super::WithInterval;

/// A diagnosis, schema `diagnosis/1`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Diagnosis {
    /// How far the diagnosis went; `where` if effects were not sought.
    #[serde(default)]
    pub stage: Option<String>,
    /// The answer.
    pub verdict: DiagnosisVerdict,
    /// Effects found, in the order of conditioning.
    #[serde(default)]
    pub effects: Vec<Effect>,
    /// Every effect that was tried.
    #[serde(default)]
    pub candidates: Vec<Candidate>,
    /// Evidence by place in the equations.
    #[serde(default)]
    pub ports: Vec<PortEvidence>,
    /// The gap by situation, largest first.
    #[serde(default, rename = "where")]
    pub cells: Vec<CellGap>,
    /// What adding the effects changes.
    #[serde(default)]
    pub how_far: Option<HowFar>,
    /// Errors of the calibrated plant by horizon.
    #[serde(default)]
    pub baseline: Vec<HorizonError>,
    /// What is doubtful about the data.
    #[serde(default)]
    pub data_quality: Vec<DataQualityFinding>,
    /// Every person of the cohort.
    #[serde(default)]
    pub people: Vec<DiagnosisPerson>,
    /// The plant that was diagnosed.
    #[serde(default)]
    pub plant: Option<String>,
}

impl Diagnosis {
    /// Whether effects were sought at all.
    #[must_use]
    pub fn sought_effects(&self) -> bool {
        self.stage.as_deref() != Some("where")
    }
}

/// The answer of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DiagnosisVerdict {
    /// No gap that the data can tell from none.
    None,
    /// At least one named effect.
    Effect,
    /// A gap that nothing tried explains.
    Unknown,
}

/// An effect that was found.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Effect {
    /// Its name.
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
    #[serde(default)]
    pub confusable_with: Vec<String>,
}

/// An effect that was tried.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Candidate {
    /// Its name.
    pub effect: String,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
    /// Probability among the candidates.
    pub probability: f64,
}

/// Evidence that something is missing at a port.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct PortEvidence {
    /// Its name.
    pub port: String,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
    /// Probability among the ports.
    pub probability: f64,
}

/// The gap in one situation.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct CellGap {
    /// `hour`, `context`, `glucose_band`, `person` or `horizon`.
    pub factor: String,
    /// Which part of it.
    pub level: String,
    /// Mean of observed minus predicted, mg/dL: positive where glucose is under-predicted.
    pub mean_error_mg_dl: f64,
    /// Lower end of the simultaneous interval, mg/dL.
    pub lower: f64,
    /// Upper end of the simultaneous interval, mg/dL.
    pub upper: f64,
    /// p-value adjusted for all cells.
    pub p_adjusted: f64,
    /// Share of the mean squared error that the cell's mean error accounts for.
    pub share_of_gap: f64,
    /// Length of the free runs, min.
    #[serde(default)]
    pub horizon_minutes: Option<u32>,
    /// People who contribute.
    #[serde(default)]
    pub people: Option<usize>,
}

/// What adding the effects found changes.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct HowFar {
    /// Held-out errors.
    #[serde(default)]
    pub horizons: Vec<HorizonChange>,
    /// Equivalence of outcomes.
    #[serde(default)]
    pub outcomes: Vec<OutcomeChange>,
}

/// Held-out error at one horizon, before and after.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct HorizonChange {
    /// Horizon, min.
    pub minutes: u32,
    /// Mean absolute error before, mg/dL.
    pub mae_before: f64,
    /// Mean absolute error after, mg/dL.
    pub mae_after: f64,
    /// After minus before, mg/dL.
    pub difference: WithInterval,
}

/// Equivalence of one outcome, before and after.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct OutcomeChange {
    /// The outcome's key.
    pub metric: String,
    /// Its margin.
    pub margin: f64,
    /// p before.
    pub p_before: f64,
    /// p after.
    pub p_after: f64,
}

/// Errors of the calibrated plant at one horizon.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct HorizonError {
    /// Horizon, min.
    pub minutes: u32,
    /// Mean absolute error, mg/dL.
    pub mae: WithInterval,
    /// Root mean squared error, mg/dL.
    pub rmse: WithInterval,
    /// Mean of observed minus predicted, mg/dL.
    pub bias: WithInterval,
}

/// Something doubtful about a person's data.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct DataQualityFinding {
    /// Name of the check.
    pub check: String,
    /// The person.
    pub person_id: String,
    /// What was found.
    pub finding: String,
    /// A number that goes with it.
    #[serde(default)]
    pub estimate: Option<FindingEstimate>,
}

/// The number of a finding.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct FindingEstimate {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
    /// Unit.
    pub unit: String,
}

/// One person of the cohort.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct DiagnosisPerson {
    /// The person.
    pub person_id: String,
    /// Days of record.
    pub days: usize,
    /// Why the person is left out; absent for one who was diagnosed.
    #[serde(default)]
    pub excluded: Option<String>,
}
