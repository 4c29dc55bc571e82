//! `example_day.json`: a day or a few consecutive ones of one person, measured and simulated.
//!
//! ```json
//! {"person_id": "...", "date": "2024-03-01", "days": 1, "time": ["00:00", "00:05"],
//!  "cgm": [101.0, null], "population": [101.0, 103.0], "twin": [101.0, 102.5],
//!  "ode": [101.0, 104.0], "closest": [101.0, 102.0], "insulin_u_h": [0.8, 0.8], "carbs_g": [0.0, 30.0],
//!  "heart_rate_over_baseline": [1.05, null], "sleep_efficiency": [0.9, null],
//!  "outcomes": {"cgm": {"tbr": 1.9, "tir": 83.1, "tar": 15.0},
//!    "twin": {"tbr": 4.7, "tir": 88.4, "tar": 6.8}},
//!  "chosen": "..."}
//! ```

use serde::Deserialize;

use super::lenient::lenient;
use crate::{Part, ReportError};

/// Days in 5-minute steps; every series has as many values as `time`, or none.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ExampleDay {
    /// The person.
    pub person_id: String,
    /// The day or days, as they should be shown.
    pub date: String,
    /// How many days, where the file says so.
    #[serde(default, deserialize_with = "lenient")]
    pub days: Option<u32>,
    /// Wall clock of every step, `HH:MM`, from the first day's first step on.
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
    /// Glucose of the closest virtual patient, mg/dL.
    #[serde(default)]
    pub closest: Vec<Option<f64>>,
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
    /// Times in ranges of each series.
    #[serde(default, deserialize_with = "lenient")]
    pub outcomes: Option<DayOutcomes>,
    /// By what rule person and days were chosen.
    #[serde(default)]
    pub chosen: Option<String>,
}

/// Times in ranges of the sensor and of each simulated series over the days.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct DayOutcomes {
    /// Of the sensor.
    #[serde(deserialize_with = "lenient")]
    pub cgm: Option<TimeInRanges>,
    /// Of the twin.
    #[serde(deserialize_with = "lenient")]
    pub twin: Option<TimeInRanges>,
    /// Of the population network.
    #[serde(deserialize_with = "lenient")]
    pub population: Option<TimeInRanges>,
    /// Of the ODE model with population parameters.
    #[serde(deserialize_with = "lenient")]
    pub ode: Option<TimeInRanges>,
    /// Of the closest virtual patient.
    #[serde(deserialize_with = "lenient")]
    pub closest: Option<TimeInRanges>,
}

/// Shares of the readings, %.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct TimeInRanges {
    /// Below 70 mg/dL.
    pub tbr: f64,
    /// From 70 to 180 mg/dL.
    pub tir: f64,
    /// Above 180 mg/dL.
    pub tar: f64,
}

impl ExampleDay {
    /// Checks that all series fit the clock.
    pub(crate) fn check(&self) -> Result<(), ReportError> {
        for (series, values) in [
            ("cgm", &self.cgm),
            ("population", &self.population),
            ("twin", &self.twin),
            ("ode", &self.ode),
            ("closest", &self.closest),
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
