//! `example_day.json`: one day of one person, measured and simulated.
//!
//! ```json
//! {"person_id": "...", "date": "2024-03-01", "time": ["00:00", "00:05"],
//!  "cgm": [101.0, null], "population": [101.0, 103.0], "twin": [101.0, 102.5],
//!  "ode": [101.0, 104.0], "insulin_u_h": [0.8, 0.8], "carbs_g": [0.0, 30.0],
//!  "heart_rate_over_baseline": [1.05, null], "sleep_efficiency": [0.9, null]}
//! ```

use serde::Deserialize;

use crate::{Part, ReportError};

/// One day in 5-minute steps; every series has as many values as `time`, or none.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ExampleDay {
    /// The person.
    pub person_id: String,
    /// The day, as it should be shown.
    pub date: String,
    /// Wall clock of every step, `HH:MM`.
    pub time: Vec<String>,
    /// Sensor glucose, mg/dL.
    #[serde(default)]
    pub cgm: Vec<Option<f64>>,
    /// Glucose of the population network, mg/dL.
    #[serde(default)]
    pub population: Vec<Option<f64>>,
    /// Glucose of the person's twin, mg/dL.
    #[serde(default)]
    pub twin: Vec<Option<f64>>,
    /// Glucose of the ODE model, mg/dL.
    #[serde(default)]
    pub ode: Vec<Option<f64>>,
    /// Insulin, all of it as a rate, U/h.
    #[serde(default)]
    pub insulin_u_h: Vec<Option<f64>>,
    /// Carbohydrate in each step, g.
    #[serde(default)]
    pub carbs_g: Vec<Option<f64>>,
    /// Heart rate over its resting baseline, a difference, 1/min; 0 at rest.
    #[serde(default)]
    pub heart_rate_over_baseline: Vec<Option<f64>>,
    /// Share of each step asleep, 0 to 1.
    #[serde(default)]
    pub sleep_efficiency: Vec<Option<f64>>,
}

impl ExampleDay {
    /// Checks that all series fit the clock.
    pub(crate) fn check(&self) -> Result<(), ReportError> {
        for (series, values) in [
            ("cgm", &self.cgm),
            ("population", &self.population),
            ("twin", &self.twin),
            ("ode", &self.ode),
            ("insulin_u_h", &self.insulin_u_h),
            ("carbs_g", &self.carbs_g),
            ("heart_rate_over_baseline", &self.heart_rate_over_baseline),
            ("sleep_efficiency", &self.sleep_efficiency),
        ] {
            if !values.is_empty() && values.len() != self.time.len() {
                return Err(ReportError::UnevenSeries {
                    part: Part::ExampleDay,
                    series,
                    found: values.len(),
                    of: "time",
                    expected: self.time.len(),
                });
            }
        }
        Ok(())
    }
}
