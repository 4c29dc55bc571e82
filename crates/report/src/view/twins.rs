//! `twins.json`: the twin of every person.
//!
//! ```json
//! {"schema": "twins/1", "people": [{"person_id": "...", "windows_train": 210,
//!  "windows_test": 95, "excluded": null, "loss_first": 1.3, "loss_last": 0.4,
//!  "rmse_population": 52.1, "rmse_twin": 38.4}]}
//! ```

use serde::Deserialize;

/// Twins of a cohort.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Twins {
    /// One entry a person.
    pub people: Vec<TwinPerson>,
}

/// One person's twin, or why there is none.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct TwinPerson {
    /// The person.
    pub person_id: String,
    /// Windows used for training.
    #[serde(default)]
    pub windows_train: Option<usize>,
    /// Windows used for testing.
    #[serde(default)]
    pub windows_test: Option<usize>,
    /// Why there is no twin; absent where there is one.
    #[serde(default)]
    pub excluded: Option<String>,
    /// Training loss of the first epoch.
    #[serde(default)]
    pub loss_first: Option<f64>,
    /// Training loss of the last epoch.
    #[serde(default)]
    pub loss_last: Option<f64>,
    /// Error of the population model on the test windows, mg/dL.
    #[serde(default)]
    pub rmse_population: Option<f64>,
    /// Error of the twin on the test windows, mg/dL.
    #[serde(default)]
    pub rmse_twin: Option<f64>,
}
