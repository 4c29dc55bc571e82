//! `agp.json`: ambulatory glucose profile, measured and simulated.
//!
//! ```json
//! {"person_id": "cohort", "hour": [0.0, 0.25],
//!  "observed": {"p05": [70, 71], "p25": [95, 96], "p50": [120, 121], "p75": [160, 161],
//!               "p95": [230, 231]},
//!  "twin": {"p05": [72, 72], "p25": [97, 98], "p50": [122, 122], "p75": [158, 158],
//!           "p95": [225, 226]}}
//! ```

use serde::Deserialize;

use crate::{Part, ReportError};

/// Percentiles of glucose by time of day.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Agp {
    /// The person, or `cohort` for all people together.
    pub person_id: String,
    /// Time of day, h, from 0 to 24.
    pub hour: Vec<f64>,
    /// Of the sensor.
    pub observed: Percentiles,
    /// Of the twin.
    #[serde(default)]
    pub twin: Option<Percentiles>,
}

/// Percentiles of glucose, mg/dL; one value a time of day.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Percentiles {
    /// 5th percentile.
    pub p05: Vec<Option<f64>>,
    /// 25th percentile.
    pub p25: Vec<Option<f64>>,
    /// Median.
    pub p50: Vec<Option<f64>>,
    /// 75th percentile.
    pub p75: Vec<Option<f64>>,
    /// 95th percentile.
    pub p95: Vec<Option<f64>>,
}

impl Agp {
    /// Checks that all percentiles fit the clock.
    pub(crate) fn check(&self) -> Result<(), ReportError> {
        for percentiles in [Some(&self.observed), self.twin.as_ref()].into_iter().flatten() {
            for (series, values) in [
                ("p05", &percentiles.p05),
                ("p25", &percentiles.p25),
                ("p50", &percentiles.p50),
                ("p75", &percentiles.p75),
                ("p95", &percentiles.p95),
            ] {
                if values.len() != self.hour.len() {
                    return Err(ReportError::UnevenSeries {
                        part: Part::Agp,
                        series,
                        found: values.len(),
                        of: "hour",
                        expected: self.hour.len(),
                    });
                }
            }
        }
        Ok(())
    }
}
