//! `outcomes.json`: the six glucose outcomes of every method, and forecast errors.
//!
//! ```json
//! {"schema": "outcomes/1", "cohort": "...", "people": 12, "windows": 340, "window_minutes": 300,
//!  "exclusions": [{"person_id": "...", "reason": "..."}],
//!  "training_days": [],
//!  "methods": [{"name": "twin", "label": "Digital twin", "rows": [
//!    {"metric": "tir", "unit": "%", "margin": 5.0,
//!     "actual": {"mean": 70.5, "sd": 16.2}, "simulated": {"mean": 70.3, "sd": 24.8},
//!     "difference": {"value": -0.2, "lower": -1.1, "upper": 0.7},
//!     "difference_t": {"value": -0.2, "lower": -1.2, "upper": 0.8}, "p": 0.0003,
//!     "equivalent": true, "p_unbiased": 0.0002}],
//!    "rmse_5h": {"mean": 38.4, "sd": 9.0}}],
//!  "ablation": [{"name": "time_only", "label": "Time only", "rows": []}],
//!  "scenarios": [{"scenario": "meal", "label": "Meals", "people": 12, "windows": 96,
//!    "methods": [{"name": "twin", "label": "Digital twin", "rows": []}]}],
//!  "forecast": [{"method": "twin", "minutes": 30, "rmse": {"mean": 18.1, "sd": 4.2}}],
//!  "comparisons": [{"first": "twin", "second": "ode", "quantity": "RMSE over 5 h",
//!    "unit": "mg/dL", "difference": {"value": -4.1, "lower": -6.0, "upper": -2.3}, "p": 0.002,
//!    "p_holm": 0.01}],
//!  "interval": {"level": 0.9}}
//! ```

use serde::Deserialize;

use super::lenient::lenient;
use super::{Spread, WithInterval};

/// Outcomes over the people of a cohort.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Outcomes {
    /// Name of the cohort.
    pub cohort: String,
    /// Number of people evaluated.
    pub people: usize,
    /// Number of windows evaluated, over all people.
    pub windows: usize,
    /// Length of a window, min.
    pub window_minutes: u32,
    /// People left out, with the reason.
    #[serde(default)]
    pub exclusions: Vec<Exclusion>,
    /// The sensor on the training days in the place of a method; empty where the file does not have it.
    #[serde(default)]
    pub training_days: Vec<OutcomeRow>,
    /// One entry a method, the method of interest first.
    pub methods: Vec<Method>,
    /// Twins that see other personal inputs, over all windows.
    #[serde(default)]
    pub ablation: Vec<Method>,
    /// Windows that begin with an event.
    #[serde(default)]
    pub scenarios: Vec<ScenarioOutcomes>,
    /// Forecast errors, one entry a method and horizon.
    #[serde(default)]
    pub forecast: Vec<ForecastRow>,
    /// Paired comparisons of two methods over people.
    #[serde(default)]
    pub comparisons: Vec<Comparison>,
    /// How the intervals of differences came about.
    #[serde(default)]
    pub interval: Option<IntervalMethod>,
}

/// How intervals came about.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct IntervalMethod {
    /// Level, 0 to 1.
    pub level: f64,
}

/// A person who was left out.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct Exclusion {
    /// The person.
    pub person_id: String,
    /// Why.
    pub reason: String,
}

/// One simulation method against the real outcomes.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Method {
    /// Key, e.g. `twin`.
    pub name: String,
    /// Name for people, e.g. `Digital twin`.
    pub label: String,
    /// One row an outcome.
    pub rows: Vec<OutcomeRow>,
    /// Root mean squared error over the windows, mg/dL.
    #[serde(default, deserialize_with = "lenient")]
    pub rmse_5h: Option<Spread>,
}

/// Outcomes over the windows that begin with one kind of event.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ScenarioOutcomes {
    /// Name for people, e.g. `Meals`.
    pub label: String,
    /// Number of people with such windows.
    pub people: usize,
    /// Number of such windows, over all people.
    pub windows: usize,
    /// One entry a method; empty where too few people have such windows.
    #[serde(default)]
    pub methods: Vec<Method>,
}

/// One outcome of one method, over people.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct OutcomeRow {
    /// Key: `tir`, `tar`, `tbr`, `lbgi`, `hbgi` or `mg`.
    pub metric: String,
    /// Unit; empty where dimensionless.
    pub unit: String,
    /// Equivalence margin in that unit.
    pub margin: f64,
    /// The real outcome.
    pub actual: Spread,
    /// The simulated outcome.
    pub simulated: Spread,
    /// Mean of simulated minus actual with its bootstrap interval over people.
    pub difference: WithInterval,
    /// The same with the interval of the test: equivalence is concluded where it lies within the
    /// margin.
    #[serde(default, deserialize_with = "lenient")]
    pub difference_t: Option<WithInterval>,
    /// The larger p of the two one-sided tests.
    pub p: f64,
    /// Whether equivalence is concluded.
    pub equivalent: bool,
    /// The p that the same scatter between people would give without any bias.
    #[serde(default, deserialize_with = "lenient")]
    pub p_unbiased: Option<f64>,
}

/// Level of the equivalence tests.
const LEVEL: f64 = 0.05;

impl OutcomeRow {
    /// Mean of simulated minus actual with the interval of the test, where the file has it.
    #[must_use]
    pub fn tested_difference(&self) -> WithInterval {
        self.difference_t.unwrap_or(self.difference)
    }

    /// Whether so few people with so much scatter between them cannot show equivalence, however
    /// good the method; false where the file does not say.
    #[must_use]
    pub fn cannot_be_shown(&self) -> bool {
        !self.equivalent && self.p_unbiased.is_some_and(|p| p >= LEVEL)
    }
}

/// Forecast error of one method at one horizon.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ForecastRow {
    /// Name of the method.
    pub method: String,
    /// Horizon, min.
    pub minutes: u32,
    /// Root mean squared error over people, mg/dL.
    pub rmse: Spread,
}

/// One quantity of two methods, compared within people.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Comparison {
    /// Name of the first method.
    pub first: String,
    /// Name of the second method.
    pub second: String,
    /// What is compared, e.g. `RMSE over 5 h`.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// Mean over people of first minus second, with its bootstrap interval over people.
    pub difference: WithInterval,
    /// p of the signed-rank test, where it was made.
    #[serde(default)]
    pub p: Option<f64>,
    /// That p adjusted for all comparisons of the same first method (Holm).
    #[serde(default, deserialize_with = "lenient")]
    pub p_holm: Option<f64>,
}
