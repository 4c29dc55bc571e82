//! `thresholds.json`: the evidence that an effect or a port must show before it is named.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::document::Document;
use crate::error::ContractError;

impl Document for Thresholds {
    const FILE: &'static str = "thresholds.json";
    const SCHEMA: &'static str = "";

    fn check(&self) -> Result<(), ContractError> {
        let wrong = |problem| Err(ContractError::Value { file: Self::FILE, problem });
        if !(self.temperature.is_finite() && self.temperature > 0.0) {
            return wrong("the temperature must be a number above 0");
        }
        for threshold in self.by_name.values().chain([&self.other]) {
            let ascend = threshold.steps.is_sorted_by(|a, b| a.person_days < b.person_days);
            if threshold.steps.is_empty() || !ascend {
                return wrong("a threshold needs one step or more, in ascending person_days");
            }
        }
        Ok(())
    }
}

/// Thresholds in nats, fixed on worlds in which nothing is missing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Thresholds {
    /// What they were fixed on.
    pub source: String,
    /// By effect, and port with scale.
    pub by_name: BTreeMap<String, Threshold>,
    /// For what is not named above.
    pub other: Threshold,
    /// Nats of evidence over the threshold by which the odds of an answer rise e-fold.
    pub temperature: f64,
}

/// One threshold, by the size of the cohort.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Threshold {
    /// Ascending, and not empty.
    pub steps: Vec<ThresholdStep>,
}

/// The evidence that is needed in cohorts of up to a size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ThresholdStep {
    /// Person-days up to which it holds.
    pub person_days: f64,
    /// Least evidence, nats.
    pub nats: f64,
}

impl Threshold {
    /// The evidence needed over so many person-days; beyond the last step it grows with them.
    #[must_use]
    pub fn over(&self, person_days: f64) -> f64 {
        match (self.steps.iter().find(|s| person_days <= s.person_days), self.steps.last()) {
            (Some(step), _) => step.nats,
            (None, Some(last)) => last.nats * person_days / last.person_days,
            (None, None) => f64::INFINITY,
        }
    }
}
