//! `agp.json`: the ambulatory glucose profile, measured and simulated.

use crate::document::even;
use crate::{ContractError, Document};

/// Percentiles of glucose by time of day, over held-out windows.
#[apply(strict!)]
pub struct GlucoseProfile {
    /// `agp/1`.
    pub schema: String,
    /// The person, or `cohort` for all people together.
    pub person_id: String,
    /// Middle of each slot of the day, h.
    pub hour: Vec<f64>,
    /// Of the sensor.
    pub observed: Percentiles,
    /// Of the twin.
    pub twin: Percentiles,
    /// Held-out windows behind both.
    pub windows: usize,
}

/// Percentiles of glucose, mg/dL, one value a slot of the day; `None` where a slot has no sample.
#[apply(strict!)]
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

impl Percentiles {
    /// Checks that each has one value a slot.
    pub(crate) fn even(&self, file: &'static str, slots: usize) -> Result<(), ContractError> {
        let names = ["p05", "p25", "p50", "p75", "p95"];
        let lengths = [&self.p05, &self.p25, &self.p50, &self.p75, &self.p95].map(Vec::len);
        even(file, ("hour", slots), names.into_iter().zip(lengths))
    }
}

impl Document for GlucoseProfile {
    const FILE: &'static str = "agp.json";
    const SCHEMA: &'static str = "agp/1";

    fn check(&self) -> Result<(), ContractError> {
        let slots = self.hour.len();
        [&self.observed, &self.twin].into_iter().try_for_each(|of| of.even(Self::FILE, slots))
    }
}
