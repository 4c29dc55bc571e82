//! `outcomes.json`: the six outcomes of every method, and forecast errors.

use serde::{Deserialize, Serialize};

use crate::{Spread, Summary, WithInterval};

/// `outcomes.json`: the six outcomes of every method, and forecast errors.
#[apply(strict!)]
pub struct OutcomesTable {
    /// `outcomes/2`.
    pub schema: String,
    /// Name of the cohort.
    pub cohort: String,
    /// People judged.
    pub people: usize,
    /// Windows judged, over all people.
    pub windows: usize,
    /// Length of a window, min.
    pub window_minutes: u32,
    /// How the intervals were made.
    pub interval: IntervalMethod,
    /// People left out, with the reason.
    pub exclusions: Vec<ExclusionRow>,
    /// The sensor on the training days in place of a method: what a person's own weeks tell of the next. An
    /// outcome that is not equivalent here changes too much from week to week to be asked of a simulator
    /// that was fitted to these days.
    pub training_days: Vec<OutcomeRow>,
    /// One entry a method, the twin first; twins with other inputs are in `ablation`.
    pub methods: Vec<MethodRows>,
    /// Five-hour error of twins against other methods'.
    pub comparisons: Vec<Comparison>,
    /// Twins that see other personal inputs, over all windows.
    pub ablation: Vec<MethodRows>,
    /// Windows that begin with an event: twins with all and with other inputs, and the population
    /// model (paper, Table `inputsContributions`).
    pub scenarios: Vec<ScenarioTable>,
    /// One entry a forecaster and horizon.
    pub forecast: Vec<ForecastRow>,
}

/// How intervals were made.
#[apply(strict!)]
pub struct IntervalMethod {
    /// In words.
    pub method: String,
    /// Confidence level.
    pub level: f64,
    /// Bootstrap samples.
    pub replicates: usize,
}

/// A person who was left out.
#[apply(strict!)]
#[derive(Eq)]
pub struct ExclusionRow {
    /// The person's identifier.
    pub person_id: String,
    /// Why.
    pub reason: String,
}

/// People left out of an evaluation that judges too few for a test: in place of the outcomes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Exclusions(pub Vec<ExclusionRow>);

/// One method against the sensor.
#[apply(strict!)]
pub struct MethodRows {
    /// The key of the method.
    pub name: String,
    /// The name for people.
    pub label: String,
    /// One row an outcome.
    pub rows: Vec<OutcomeRow>,
    /// Root mean squared error over the windows, mg/dL, over people.
    pub rmse_5h: Spread,
    /// Windows whose start is no steady state although one was asked for.
    pub starts_not_at_rest: usize,
}

/// The windows of one scenario.
#[apply(strict!)]
pub struct ScenarioTable {
    /// The key of the scenario.
    pub scenario: String,
    /// The name for people.
    pub label: String,
    /// People with such windows.
    pub people: usize,
    /// Windows, over all people.
    pub windows: usize,
    /// One entry a method; empty below two people.
    pub methods: Vec<MethodRows>,
}

/// One outcome of one method, over people.
#[apply(strict!)]
pub struct OutcomeRow {
    /// `tir`, `tar`, `tbr`, `lbgi`, `hbgi` or `mg`.
    pub metric: String,
    /// Its unit; empty where dimensionless.
    pub unit: String,
    /// Equivalence margin in that unit.
    pub margin: f64,
    /// The sensor's.
    pub actual: Spread,
    /// The method's.
    pub simulated: Spread,
    /// Simulated minus actual with its bootstrap interval over people.
    pub difference: WithInterval,
    /// The same with the interval of the two one-sided t-tests.
    pub difference_t: WithInterval,
    /// The larger p of the two one-sided tests.
    pub p: f64,
    /// That p adjusted for six outcomes (Holm).
    pub p_holm: f64,
    /// Whether p is below the level.
    pub equivalent: bool,
    /// The p that the same scatter between people would give without any bias: where it is above the
    /// level, so few people cannot show equivalence.
    pub p_unbiased: f64,
}

/// One outcome of one method against the real ones: the paper's table.
#[apply(strict!)]
pub struct Equivalence {
    /// `tir`, `tar`, `tbr`, `lbgi`, `hbgi` or `mg`.
    pub metric: String,
    /// Its unit; empty where dimensionless.
    pub unit: String,
    /// Equivalence margin in that unit.
    pub margin: f64,
    /// Of the real outcome, in that unit.
    pub actual: Summary,
    /// Of the simulated outcome, in that unit.
    pub simulated: Summary,
    /// Simulated minus actual with the interval of the two one-sided t-tests.
    pub difference: WithInterval,
    /// The larger p of the two one-sided tests.
    pub p: f64,
    /// Whether p is below the level.
    pub equivalent: bool,
}

/// A figure of the twin against the same figure of another method, compared within people.
#[apply(strict!)]
pub struct Comparison {
    /// The key of the first method, the twin.
    pub first: String,
    /// The key of the other method.
    pub second: String,
    /// What is compared.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// Mean over people of first minus second; negative where the twin errs less.
    pub difference: WithInterval,
    /// p of the signed-rank test over people.
    pub p: f64,
    /// That p adjusted for all comparisons of the same first method (Holm).
    pub p_holm: f64,
}

/// Error of one forecaster at one horizon.
#[apply(strict!)]
pub struct ForecastRow {
    /// The key of the forecaster.
    pub method: String,
    /// The horizon, min.
    pub minutes: u32,
    /// People whom it forecasts: who has too few training days for a regression is missing there.
    pub people: usize,
    /// Root mean squared error, mg/dL, over people.
    pub rmse: Spread,
}

/// Level of the equivalence tests.
const LEVEL: f64 = 0.05;

impl OutcomeRow {
    /// Whether so few people, between whom this method's differences scatter so much, could not show equivalence if it
    /// had no bias.
    #[must_use]
    pub fn cannot_be_shown(&self) -> bool {
        !self.equivalent && self.p_unbiased >= LEVEL
    }
}
