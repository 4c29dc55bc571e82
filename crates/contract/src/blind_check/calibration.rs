//! `calibration.json`: the worlds on which thresholds are fixed.

use serde::{Deserialize, Serialize};

use super::{Label, Verdict};
use crate::diagnosis::{CandidateEffect, FoundEffect, PortEvidence};
use crate::document::documents;

documents! { CalibrationTable: "calibration.json", "calibration/2"; }

/// Raw evidence on worlds whose labels are known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CalibrationTable {
    /// `calibration/2`.
    pub schema: String,
    /// Seed from which the plan was drawn.
    pub master_seed: u64,
    /// The worlds, all of one generator.
    pub worlds: Vec<CalibrationWorld>,
}

/// Truth and evidence of one world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CalibrationWorld {
    /// The truth, people and days with it.
    pub label: Label,
    /// The answer under the thresholds in force.
    pub verdict: Verdict,
    /// Effects named under the thresholds in force.
    pub found: Vec<FoundEffect>,
    /// Evidence of every effect that was tried.
    pub candidates: Vec<CandidateEffect>,
    /// Evidence at every port.
    pub ports: Vec<PortEvidence>,
    /// Why there is no answer.
    pub failure: Option<String>,
}
