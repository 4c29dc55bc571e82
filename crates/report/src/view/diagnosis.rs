//! `diagnosis.json`: where the gap lies, which effect explains it, how far it shrinks.

use serde::Deserialize;

use super::lenient::{entries, lenient};
use super::{Range, WithInterval};

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
    /// Effects that were not tried.
    #[serde(default, deserialize_with = "entries")]
    pub untried: Vec<Untried>,
    /// How probably effects would have been found.
    #[serde(default, deserialize_with = "entries")]
    pub power: Vec<DetectionPower>,
    /// Evidence by place in the equations.
    #[serde(default)]
    pub ports: Vec<PortEvidence>,
    /// What a posterior said, if one decided.
    #[serde(default, deserialize_with = "lenient")]
    pub posterior: Option<PosteriorSaid>,
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
    /// What has to be known to read the answer for this plant.
    #[serde(default, deserialize_with = "entries")]
    pub notes: Vec<String>,
    /// What residual networks have absorbed, for twins.
    #[serde(default, deserialize_with = "lenient")]
    pub absorbed: Option<Absorbed>,
}

/// What a posterior said.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct PosteriorSaid {
    /// Probability that something is missing.
    pub something: f64,
    /// Probability of an effect from which on it is named.
    pub names_from: f64,
}

/// Evidence and errors with residual networks and without.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Absorbed {
    /// Effects named without the residual networks.
    #[serde(default, deserialize_with = "entries")]
    pub found_without: Vec<String>,
    /// Evidence by effect.
    #[serde(default, deserialize_with = "entries")]
    pub effects: Vec<AbsorbedEffect>,
    /// Errors by horizon.
    #[serde(default, deserialize_with = "entries")]
    pub baseline: Vec<AbsorbedError>,
}

/// Evidence for one effect.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct AbsorbedEffect {
    /// Its name.
    pub effect: String,
    /// Without the residual networks, nats.
    #[serde(default, deserialize_with = "lenient")]
    pub evidence_before: Option<f64>,
    /// With them, nats.
    #[serde(default, deserialize_with = "lenient")]
    pub evidence_after: Option<f64>,
    /// Share that is gone.
    #[serde(default, deserialize_with = "lenient")]
    pub share: Option<f64>,
}

/// Mean absolute error at one horizon, mg/dL.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct AbsorbedError {
    /// Horizon, min.
    pub minutes: u32,
    /// Without the residual networks.
    pub mae_before: f64,
    /// With them.
    pub mae_after: f64,
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
    #[serde(default)]
    pub port: String,
    /// Held-out evidence, nats.
    #[serde(default, deserialize_with = "lenient")]
    pub gain_nats: Option<f64>,
    /// Probability among the candidates.
    #[serde(default, deserialize_with = "lenient")]
    pub probability: Option<f64>,
    /// Amplitude; 1 is the published size.
    #[serde(default, deserialize_with = "lenient")]
    pub amplitude: Option<Range>,
    /// Effects that the data cannot tell from it.
    #[serde(default, deserialize_with = "entries")]
    pub confusable_with: Vec<String>,
    /// The same amplitude in every person.
    #[serde(default, deserialize_with = "entries")]
    pub people: Vec<PersonAmplitude>,
    /// Reasons to doubt the name.
    #[serde(default, deserialize_with = "entries")]
    pub questioned: Vec<String>,
}

/// The amplitude of an effect in one person.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct PersonAmplitude {
    /// The person.
    pub person_id: String,
    /// Estimate; 1 is the published size.
    #[serde(default, deserialize_with = "lenient")]
    pub amplitude: Option<f64>,
    /// Lower end.
    #[serde(default, deserialize_with = "lenient")]
    pub lower: Option<f64>,
    /// Upper end.
    #[serde(default, deserialize_with = "lenient")]
    pub upper: Option<f64>,
    /// Evidence in this person's data, nats.
    #[serde(default, deserialize_with = "lenient")]
    pub gain_nats: Option<f64>,
}

/// An effect that was not tried.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct Untried {
    /// Its name.
    pub effect: String,
    /// Why, e.g. the channel that is missing.
    #[serde(default)]
    pub reason: String,
}

/// How probably an effect of some size would have been found in data like these.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct DetectionPower {
    /// The effect; absent where any effect is meant.
    #[serde(default)]
    pub effect: Option<String>,
    /// Mean absolute shift of glucose that the effect causes, mg/dL.
    pub shift_mg_dl: f64,
    /// Probability of finding it.
    pub power: f64,
}

/// An effect that was tried.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Candidate {
    /// Its name.
    pub effect: String,
    /// Held-out evidence, nats.
    #[serde(default, deserialize_with = "lenient")]
    pub gain_nats: Option<f64>,
    /// Probability among the candidates.
    #[serde(default, deserialize_with = "lenient")]
    pub probability: Option<f64>,
}

/// Evidence that something is missing at a port.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct PortEvidence {
    /// Its name.
    pub port: String,
    /// Held-out evidence, nats.
    #[serde(default, deserialize_with = "lenient")]
    pub gain_nats: Option<f64>,
    /// Probability among the ports.
    #[serde(default, deserialize_with = "lenient")]
    pub probability: Option<f64>,
    /// Ports that the data cannot tell from it.
    #[serde(default, deserialize_with = "entries")]
    pub confusable_with: Vec<String>,
    /// Unit of the course.
    #[serde(default)]
    pub unit: String,
    /// What is lacking there through the day, beyond its mean.
    #[serde(default, deserialize_with = "entries")]
    pub course: Vec<CoursePart>,
}

/// What is lacking at a port in a part of the day.
#[derive(Debug, Clone, PartialEq, Deserialize)]
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

impl CoursePart {
    /// First hour.
    pub(crate) fn from(&self) -> Option<f64> {
        self.hours.split_once('-')?.0.parse().ok()
    }

    /// Hour at which it ends.
    pub(crate) fn to(&self) -> Option<f64> {
        self.hours.split_once('-')?.1.parse().ok()
    }

    /// Whether the interval leaves 0 out.
    pub(crate) fn is_certain(&self) -> bool {
        self.lower > 0.0 || self.upper < 0.0
    }
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
    /// The mean that a posterior expects of what is missing, mg/dL.
    #[serde(default)]
    pub expected_mg_dl: Option<f64>,
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
    /// Amplitudes fitted on training days.
    #[serde(default, deserialize_with = "entries")]
    pub amplitudes: Vec<FittedAmplitude>,
    /// Held-out one-step fit.
    #[serde(default, deserialize_with = "lenient")]
    pub innovations: Option<InnovationChange>,
    /// Every person's errors.
    #[serde(default, deserialize_with = "entries")]
    pub people: Vec<PersonChange>,
    /// What a reader of these figures should know.
    #[serde(default, deserialize_with = "entries")]
    pub notes: Vec<String>,
}

/// Amplitude of an effect in people's training days.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct FittedAmplitude {
    /// The effect.
    pub effect: String,
    /// Mean over people.
    #[serde(default, deserialize_with = "lenient")]
    pub mean: Option<Range>,
    /// Standard deviation between people.
    #[serde(default, deserialize_with = "lenient")]
    pub sd: Option<f64>,
}

/// One-step predictions of held-out days before and after.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct InnovationChange {
    /// Log-likelihood of a day's readings after minus before, nats.
    pub difference: WithInterval,
}

/// Held-out errors of one person.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct PersonChange {
    /// The person.
    pub person_id: String,
    /// Days held out that contribute a run.
    #[serde(default)]
    pub days: usize,
    /// Mean absolute errors before, mg/dL, one a horizon that is not reconstructed.
    #[serde(default)]
    pub mae_before: Vec<Option<f64>>,
    /// Mean absolute errors after, mg/dL.
    #[serde(default)]
    pub mae_after: Vec<Option<f64>>,
}

/// Held-out error at one horizon, before and after.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct HorizonChange {
    /// Horizon, min.
    pub minutes: u32,
    /// Mean absolute error before, mg/dL.
    #[serde(default, deserialize_with = "lenient")]
    pub mae_before: Option<f64>,
    /// Mean absolute error after, mg/dL.
    #[serde(default, deserialize_with = "lenient")]
    pub mae_after: Option<f64>,
    /// After minus before, mg/dL.
    #[serde(default, deserialize_with = "lenient")]
    pub difference: Option<Range>,
    /// Whether the effects were reconstructed from the held-out readings themselves: no prediction,
    /// but what knowing the events would remove.
    #[serde(default)]
    pub reconstructed: bool,
    /// The error that the model after would have if it were perfect, mg/dL.
    #[serde(default, deserialize_with = "lenient")]
    pub floor: Option<f64>,
    /// Share of the error above the floor that is removed.
    #[serde(default, deserialize_with = "lenient")]
    pub share_above_floor: Option<Range>,
    /// People who contribute.
    #[serde(default, deserialize_with = "lenient")]
    pub people: Option<usize>,
    /// Free runs that contribute.
    #[serde(default, deserialize_with = "lenient")]
    pub runs: Option<usize>,
}

/// Equivalence of one outcome, before and after.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct OutcomeChange {
    /// The outcome's key.
    pub metric: String,
    /// Its margin.
    #[serde(default, deserialize_with = "lenient")]
    pub margin: Option<f64>,
    /// p before.
    #[serde(default, deserialize_with = "lenient")]
    pub p_before: Option<f64>,
    /// p after.
    #[serde(default, deserialize_with = "lenient")]
    pub p_after: Option<f64>,
    /// Simulated minus measured before, in the outcome's unit.
    #[serde(default, deserialize_with = "lenient")]
    pub difference_before: Option<f64>,
    /// The same after.
    #[serde(default, deserialize_with = "lenient")]
    pub difference_after: Option<f64>,
    /// As in [`HorizonChange::reconstructed`].
    #[serde(default)]
    pub reconstructed: bool,
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
