//! The diagnosis as it is written: `diagnosis.json`, schema `diagnosis/1`.

use serde::{Deserialize, Serialize};

use crate::absorbed::Absorbed;
use crate::config::DiagnosisConfig;
use crate::filter::calibration::Factor;
use crate::which::Evidence;

/// Value of [`Diagnosis::schema`].
pub const SCHEMA: &str = "diagnosis/1";

/// A diagnosis of one plant on one cohort.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// [`SCHEMA`].
    pub schema: String,
    /// How far the diagnosis went.
    pub stage: Stage,
    /// The answer.
    pub verdict: Verdict,
    /// Effects found, in the order in which the data were conditioned on them.
    pub effects: Vec<FoundEffect>,
    /// Every effect that was tried; `none` and `unknown` stand among them with their probabilities.
    pub candidates: Vec<CandidateEffect>,
    /// Effects that no record could show.
    #[serde(default)]
    pub untried: Vec<UntriedEffect>,
    /// Evidence by place in the equations.
    pub ports: Vec<PortEvidence>,
    /// How small an effect these data would have shown where thresholds decide; effects of which no believable size would
    /// have been found are missing. Empty where a posterior decides.
    #[serde(default)]
    pub power: Vec<DetectionPower>,
    /// The evidence by name before any effect is conditioned on, from which thresholds can be fixed.
    #[serde(default)]
    pub evidence: Evidence,
    /// What the posterior said, if one decided.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub posterior: Option<PosteriorSaid>,
    /// The gap by situation, largest share first.
    #[serde(rename = "where")]
    pub cells: Vec<CellGap>,
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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub absorbed: Option<Absorbed>,
    /// The seed of all resampling.
    pub seed: u64,
    /// The settings.
    pub config: DiagnosisConfig,
}

/// How far a diagnosis went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// The gap was measured and located in context; no effect was looked for.
    Where,
    /// Effects were looked for, and what adding them changes was measured.
    HowFar,
}

/// What a posterior said of a cohort.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PosteriorSaid {
    /// Probability that something is missing.
    pub something: f64,
    /// The most probable sets of one or two effects.
    pub sets: Vec<ProbableSet>,
    /// Probability that something is missing from which on the verdict is not `none`.
    pub speaks_from: f64,
    /// Probability of an effect from which on it is named.
    pub names_from: f64,
    /// What it was trained by.
    pub source: String,
}

/// A set of effects that may act together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProbableSet {
    /// One or two effects.
    pub effects: Vec<String>,
    /// Probability that these and no others act.
    pub probability: f64,
}

/// The answer of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing that the data could show is missing. Situations in `where` may still show errors: no
    /// plant fits a person in everything.
    None,
    /// At least one named effect was found.
    Effect,
    /// Something varies at a port by more than it does in anybody, and nothing that was tried explains it.
    Unknown,
}

/// A number with the ends of its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WithInterval {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

/// An effect that was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    #[serde(default)]
    pub people: Vec<PersonAmplitude>,
    /// Reasons to doubt the name, in sentences: where "how far" does not agree with it.
    #[serde(default)]
    pub questioned: Vec<String>,
}

/// An effect in one person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
pub struct UntriedEffect {
    /// The effect's name.
    pub effect: String,
    /// What is missing.
    pub reason: String,
}

/// An effect that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CandidateEffect {
    /// The effect's name.
    pub effect: String,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
    /// Probability among the candidates.
    pub probability: f64,
}

/// Evidence that something is missing at a port.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PortEvidence {
    /// The port's name.
    pub port: String,
    /// Held-out evidence, nats.
    pub gain_nats: f64,
    /// Probability among the ports.
    pub probability: f64,
    /// Ports whose changes look alike, or whose evidence is about as good.
    #[serde(default)]
    pub confusable_with: Vec<String>,
    /// Unit of the course: `factor` for the change of a factor of 1, else that of the flux, the carbohydrate or the reading.
    #[serde(default)]
    pub unit: String,
    /// What the model lacks there through the day, beyond its mean over the day, which calibration takes.
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
    /// Lower end of the interval; those of a port hold all parts in 95 of 100.
    pub lower: f64,
    /// Upper end of the interval.
    pub upper: f64,
}

/// By what a cell of `where` is set apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CellFactor {
    /// Part of the day, `HH-HH`.
    Hour,
    /// A [`Situation`](crate::context::Situation).
    Context,
    /// Filtered glucose, mg/dL.
    GlucoseBand,
    /// One person.
    Person,
    /// Length of the free run, min.
    Horizon,
}

/// The gap in one cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CellGap {
    /// By what the cell is set apart.
    pub factor: CellFactor,
    /// Which part of it this is.
    pub level: String,
    /// Mean error of free runs, observed minus predicted, mg/dL: positive where the plant
    /// under-predicts glucose. Runs of the horizon in
    /// [`LocalisationRule::horizon`](crate::LocalisationRule), except for `horizon` cells, which have
    /// their own. The mean over people of each person's mean. Runs start from the filtered
    /// state without its unexplained flux, except for cells that are set apart by glucose (bands,
    /// `after_low`, `fast_change`): the flux goes with glucose, so they keep it.
    pub mean_error_mg_dl: f64,
    /// Lower end of the simultaneous interval.
    pub lower: f64,
    /// Upper end of the simultaneous interval.
    pub upper: f64,
    /// p-value adjusted for every cell and both layers.
    pub p_adjusted: f64,
    /// Where a posterior decided: the cell's share of the gap that it expects of what is missing, as squared sizes of hours,
    /// contexts and glucose bands; 0 for persons and horizons. Otherwise the share of the mean squared free-run error
    /// that the cell's mean error accounts for: share of the runs that lie in the cell times the squared mean error over
    /// the mean squared error. Shares of cells that overlap do not add up.
    pub share_of_gap: f64,
    /// Where a posterior decided: the mean that it expects of what is missing, mg/dL, in runs of whole days from midnight;
    /// shrunken towards 0, as it is a mean over everything that may be missing. `None` for persons and horizons.
    #[serde(default)]
    pub expected_mg_dl: Option<f64>,
    /// Length of the free runs, min.
    pub horizon_minutes: u32,
    /// People who contribute.
    pub people: usize,
    /// Free runs that contribute.
    pub runs: usize,
    /// The other layer: one-step errors of the filter. `None` for persons and horizons.
    pub innovation: Option<InnovationGap>,
}

/// Mean whitened innovation of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct InnovationGap {
    /// Mean, in standard deviations of a whitened innovation; positive where the filter
    /// under-predicts.
    pub mean_sd: f64,
    /// Lower end of the simultaneous interval.
    pub lower: f64,
    /// Upper end of the simultaneous interval.
    pub upper: f64,
    /// p-value adjusted for every cell and both layers.
    pub p_adjusted: f64,
}

/// What adding the effects found changes; empty at [`Stage::Where`].
///
/// Everything is measured on days that were held out of the fits ([`how_far`](crate::how_far)).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HowFar {
    /// Held-out errors before and after, one entry a horizon; then, if events or random factors were
    /// found, entries with [`HorizonChange::reconstructed`].
    pub horizons: Vec<HorizonChange>,
    /// Outcomes before and after, of free runs of 24 h on held-out days.
    pub outcomes: Vec<OutcomeChange>,
    /// Amplitudes from training days, one entry an effect that a driver explains.
    #[serde(default)]
    pub amplitudes: Vec<AmplitudeChange>,
    /// Held-out one-step fit.
    #[serde(default)]
    pub innovations: Option<InnovationChange>,
    /// Every person's errors.
    #[serde(default)]
    pub people: Vec<PersonChange>,
    /// What limits these figures, in sentences.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// Held-out error at one horizon before and after the effects are added.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HorizonChange {
    /// Horizon, min.
    pub minutes: u32,
    /// Mean absolute error before, mg/dL: mean over people.
    pub mae_before: f64,
    /// Mean absolute error after, mg/dL: mean over people.
    pub mae_after: f64,
    /// After minus before, mg/dL.
    pub difference: WithInterval,
    /// Whether the effects were reconstructed from the held-out readings themselves. Such a row is no
    /// prediction: it says what knowing the events would remove, and must not be added to the others.
    #[serde(default)]
    pub reconstructed: bool,
    /// The error that the model after would have if it were perfect: expected absolute error by the
    /// filter's own variance, mg/dL. A bound under the noise model, not a measurement.
    #[serde(default)]
    pub floor: Option<f64>,
    /// (before - after) / (before - floor): share of the error above the floor that is removed. `None`
    /// where the distance to the floor cannot be told from a small one.
    #[serde(default)]
    pub share_above_floor: Option<WithInterval>,
    /// People who contribute.
    #[serde(default)]
    pub people: usize,
    /// Free runs that contribute.
    #[serde(default)]
    pub runs: usize,
}

/// Equivalence of one outcome before and after the effects are added.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OutcomeChange {
    /// The outcome.
    pub metric: String,
    /// Equivalence margin, in the outcome's unit.
    pub margin: f64,
    /// TOST p before.
    pub p_before: f64,
    /// TOST p after.
    pub p_after: f64,
    /// Simulated minus measured before, in the outcome's unit: mean over people.
    #[serde(default)]
    pub difference_before: f64,
    /// The same after.
    #[serde(default)]
    pub difference_after: f64,
    /// People who contribute.
    #[serde(default)]
    pub people: usize,
}

/// Amplitude of an effect in people's training days.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AmplitudeChange {
    /// The effect.
    pub effect: String,
    /// Its variant, chosen on the training days of each fold.
    pub variants: Vec<usize>,
    /// Mean over people, with a 95 % interval.
    pub mean: WithInterval,
    /// Standard deviation between people.
    pub sd: f64,
    /// Each person's amplitude, mean over folds, in the order of [`HowFar::people`].
    pub people: Vec<f64>,
}

/// One-step predictions of held-out days before and after.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InnovationChange {
    /// Log-likelihood of a day's readings before, nats: mean over people. Beyond 2.5 standard deviations
    /// it falls linearly.
    pub before: f64,
    /// The same after.
    pub after: f64,
    /// After minus before, nats a day.
    pub difference: WithInterval,
}

/// Held-out errors of one person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PersonChange {
    /// The person.
    pub person_id: String,
    /// Days held out that contribute a run.
    pub days: usize,
    /// Mean absolute errors before, mg/dL, one entry a horizon; `None` without a run.
    pub mae_before: Vec<Option<f64>>,
    /// Mean absolute errors after, mg/dL.
    pub mae_after: Vec<Option<f64>>,
    /// Mean absolute errors with hidden events and random factors reconstructed as well, mg/dL; empty
    /// where none were found. No prediction: see [`HorizonChange::reconstructed`].
    #[serde(default)]
    pub mae_reconstructed: Vec<Option<f64>>,
}

/// Errors of the calibrated plant at one horizon, with person-level 95 % intervals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HorizonError {
    /// Horizon, min.
    pub minutes: u32,
    /// Mean absolute error, mg/dL: mean over people.
    pub mae: WithInterval,
    /// Root of the mean over people of each person's mean squared error, mg/dL.
    pub rmse: WithInterval,
    /// Mean error, observed minus predicted, mg/dL: mean over people.
    pub bias: WithInterval,
    /// People who contribute.
    pub people: usize,
    /// Free runs that contribute.
    pub runs: usize,
}

/// Something doubtful about a person's data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DataQualityFinding {
    /// The check's name, e.g. `missing_channel`.
    pub check: String,
    /// The person.
    pub person_id: String,
    /// What was found.
    pub finding: String,
    /// A number that goes with it.
    pub estimate: Option<FindingEstimate>,
}

/// The number of a finding.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FindingEstimate {
    /// The estimate.
    pub value: f64,
    /// Lower end of its interval.
    pub lower: f64,
    /// Upper end of its interval.
    pub upper: f64,
    /// Unit.
    pub unit: String,
}

/// One person of the cohort.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PersonSummary {
    /// The person.
    pub person_id: String,
    /// Whole days of record.
    pub days: usize,
    /// Why the person is excluded; `None` for one who was diagnosed.
    pub excluded: Option<String>,
    /// The person's calibration; `None` for one who is excluded.
    pub calibration: Option<CalibrationSummary>,
}

/// A person's calibration in brief.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibrationSummary {
    /// Factors on the population parameters.
    pub factors: Vec<FactorEstimate>,
    /// Whether the iteration met its tolerance.
    pub converged: bool,
    /// Iterations made.
    pub iterations: usize,
    /// Posterior covariance of the factors' logarithms, in their order.
    #[serde(default)]
    pub log_covariance: Vec<Vec<f64>>,
    /// How many times the variance of what the record says is what independent steps would make it, at least 1.
    #[serde(default)]
    pub dependence: f64,
    /// Standard deviation of the whitened normalised innovations: above 1 where the filter trusts
    /// plant and sensor too much.
    pub innovation_sd: f64,
    /// Coefficients of the autoregression that whitens them.
    pub autoregression: [f64; 2],
    /// Free runs that were scored, over all horizons.
    pub runs: usize,
    /// Readings at an end of the sensor's range (40 or 400 mg/dL), which are not scored as
    /// innovations.
    pub censored_readings: usize,
    /// Steps with a dose that is not on record.
    pub unrecorded_doses: usize,
    /// Body weight used, kg.
    pub weight_kg: f64,
    /// Whether that weight is an assumption.
    pub weight_assumed: bool,
}

/// One calibrated factor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FactorEstimate {
    /// Which parameter.
    pub factor: Factor,
    /// The factor on the population value.
    pub value: f64,
    /// Posterior standard deviation of its logarithm.
    pub log_sd: f64,
    /// Whether it ended at the bound of the calibration.
    pub at_bound: bool,
}
