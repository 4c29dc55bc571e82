//! `outcomes.json`: the six glucose outcomes of every method, and forecast errors.
//!
//! ```json
//! {"schema": "outcomes/1", "cohort": "...", "people": 12, "windows": 340, "window_minutes": 300,
//!  "exclusions": [{"person_id": "...", "reason": "..."}],
//!  "methods": [{"name": "twin", "label": "Digital twin", "rows": [
//!    {"metric": "tir", "unit": "%", "margin": 5.0,
//!     "actual": {"mean": 70.5, "sd": 16.2}, "simulated": {"mean": 70.3, "sd": 24.8},
//!     "difference": {"value": -0.2, "lower": -1.1, "upper": 0.7}, "p": 0.0003,
//!     "equivalent": true}]}],
//!  "forecast": [{"method": "twin", "minutes": 30, "rmse": {"mean": 18.1, "sd": 4.2}}],
//!  "comparisons": [{"first": "twin", "second": "ode", "quantity": "RMSE over 5 h",
//!    "unit": "mg/dL", "difference": {"value": -4.1, "lower": -6.0, "upper": -2.3}, "p": 0.002}],
//!  "interval": {"level": 0.9}}
//! ```

use serde::Deserialize;

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
    /// One entry a method, the method of interest first.
    pub methods: Vec<Method>,
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
    /// Mean of simulated minus actual with its 90 % interval.
    pub difference: WithInterval,
    /// The larger p of the two one-sided tests.
    pub p: f64,
    /// Whether equivalence is concluded.
    pub equivalent: bool,
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
}
