//! `blind_check.json`: answers of the diagnosis scored against labels that it could not see.

use serde::Deserialize;

use super::lenient::{entries, lenient};

/// A blind check, schema `blind-check/1`.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct BlindCheck {
    /// Seed from which the plan was drawn.
    #[serde(deserialize_with = "lenient")]
    pub master_seed: Option<u64>,
    /// Every world.
    #[serde(deserialize_with = "entries")]
    pub worlds: Vec<World>,
    /// Truth against answer.
    #[serde(deserialize_with = "lenient")]
    pub confusion: Option<Confusion>,
    /// How often effects are found, by the shift that they cause.
    #[serde(deserialize_with = "entries")]
    pub power: Vec<PowerRow>,
    /// Null worlds in which something was found.
    #[serde(deserialize_with = "lenient")]
    pub false_alarms: Option<Share>,
    /// Worlds with one effect in which an unrelated one was named.
    #[serde(deserialize_with = "lenient")]
    pub wrong_names: Option<Share>,
    /// Worlds with an effect outside the library.
    #[serde(deserialize_with = "lenient")]
    pub unknown: Option<UnknownScore>,
    /// Worlds with two effects.
    #[serde(deserialize_with = "lenient")]
    pub pairs: Option<Pairs>,
    /// Whether probabilities come true.
    #[serde(deserialize_with = "lenient")]
    pub reliability: Option<Reliability>,
    /// Worlds whose diagnosis ended without an answer.
    #[serde(deserialize_with = "lenient")]
    pub failed: Option<Share>,
    /// What was promised.
    #[serde(deserialize_with = "entries")]
    pub targets: Vec<Target>,
}

/// How many of how many, with a 95 % interval.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Share {
    /// How many.
    pub count: usize,
    /// Of how many.
    pub of: usize,
    /// Their ratio; absent where nothing was counted.
    pub value: Option<f64>,
    /// Lower end of the exact interval.
    pub lower: Option<f64>,
    /// Upper end of the exact interval.
    pub upper: Option<f64>,
}

/// One figure that was promised.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Target {
    /// Short name.
    pub name: String,
    /// What is counted, in words.
    pub says: String,
    /// `at_least` or `at_most`.
    pub bound: String,
    /// The limit.
    pub target: Option<f64>,
    /// What was measured; absent if no world tests it.
    pub value: Option<f64>,
    /// Lower end of its interval.
    pub lower: Option<f64>,
    /// Upper end of its interval.
    pub upper: Option<f64>,
    /// The value if an answer counts whose set of effects that cannot be told apart holds the truth.
    pub value_counting_sets: Option<f64>,
    /// Worlds (or names, or probabilities) behind the value.
    pub of: usize,
    /// Whether the value meets the limit; absent if no world tests it.
    pub met: Option<bool>,
}

/// Counts of worlds by truth and by the first effect of the answer.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize)]
pub struct Confusion {
    /// Names of the columns.
    pub answers: Vec<String>,
    /// One row a truth.
    pub rows: Vec<ConfusionRow>,
}

/// The answers to one truth.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct ConfusionRow {
    /// Name of the effect, `none`, or `outside:` with the name of the effect.
    pub truth: String,
    /// Worlds, one count a column.
    pub counts: Vec<usize>,
}

/// The worlds with one effect whose shift lies in one bin.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct PowerRow {
    /// The effect; absent for all effects together.
    pub effect: Option<String>,
    /// Lower end of the bin, mg/dL.
    pub from_mg_dl: f64,
    /// Upper end of the bin, mg/dL; absent where there is none.
    pub to_mg_dl: Option<f64>,
    /// Mean shift of the worlds, mg/dL.
    pub mean_shift_mg_dl: Option<f64>,
    /// The effect, and nothing else, was named.
    pub named: Share,
    /// As `named`, or the effect stands in the set that the answer offers.
    pub named_or_in_set: Share,
    /// The answer was not "none".
    pub detected: Share,
}

/// Worlds with an effect outside the library.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct UnknownScore {
    /// Those that were called unknown.
    pub recalled: Share,
    /// Of those, the ones whose strongest port is the right one.
    pub right_port: Share,
    /// Of those, the ones whose strongest port, or one that cannot be told from it, is.
    pub right_port_or_in_set: Share,
}

/// Worlds with two effects.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Pairs {
    /// How many there are.
    pub worlds: usize,
    /// Of the names given, those that act.
    pub precision: Share,
    /// Of the effects that act, those that were named.
    pub recall: Share,
    /// Worlds in which both, and nothing else, were named.
    pub both: Share,
    /// Harmonic mean of precision and recall.
    pub f1: Option<f64>,
    /// Lower end of its interval.
    pub f1_lower: Option<f64>,
    /// Upper end of its interval.
    pub f1_upper: Option<f64>,
}

/// Stated probability against the share that came true.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Reliability {
    /// Bins that hold a probability.
    pub bins: Vec<ReliabilityBin>,
    /// Probabilities that were counted.
    pub probabilities: usize,
    /// Mean distance of stated and true.
    pub expected_calibration_error: Option<f64>,
    /// Lower end of its interval.
    pub lower: Option<f64>,
    /// Upper end of its interval.
    pub upper: Option<f64>,
}

/// Probabilities of about one size.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct ReliabilityBin {
    /// Mean of the probabilities.
    pub mean_probability: Option<f64>,
    /// How many came true.
    pub came_true: Share,
}

/// One world.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct World {
    /// The world.
    pub id: String,
    /// `null`, `single`, `pair` or `outside`.
    pub kind: String,
    /// Which simulator made it.
    pub generator: String,
    /// How basal insulin was decided.
    pub regime: String,
    /// Number of people.
    pub people: usize,
    /// Days of each.
    pub days: usize,
    /// What was done to the record whatever acts.
    pub nuisances: Vec<String>,
    /// What acts.
    pub truth: Vec<TrueEffect>,
    /// The answer in one word.
    pub verdict: String,
    /// Effects found.
    pub found: Vec<NamedEffect>,
    /// How the answer compares with the truth, in one word.
    pub outcome: String,
    /// Time that the diagnosis took, s.
    pub seconds: Option<f64>,
    /// Why there is no answer.
    pub failure: Option<String>,
}

/// An effect that acts in a world.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct TrueEffect {
    /// Its name.
    pub effect: String,
    /// Mean absolute shift of glucose that it causes, mg/dL.
    pub achieved_mg_dl: Option<f64>,
}

/// An effect that an answer names.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct NamedEffect {
    /// Its name.
    pub effect: String,
    /// Stated probability.
    pub probability: Option<f64>,
}
