//! The table from which thresholds are fixed: `calibration.json`, schema `calibration/1`.

use serde::{Deserialize, Serialize};

use crate::answer::{Answer, Candidate, Found, PortEvidence, Verdict};
use crate::label::Label;

/// Value of [`CalibrationTable::schema`].
const SCHEMA: &str = "calibration/1";

/// Raw evidence on worlds whose labels are known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibrationTable {
    /// Always `calibration/1`.
    pub schema: String,
    /// Seed from which the plan was drawn.
    pub master_seed: u64,
    /// The worlds, all of one generator.
    pub worlds: Vec<CalibrationWorld>,
}

/// Truth and evidence of one world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibrationWorld {
    /// The truth, people and days with it.
    pub label: Label,
    /// The answer under the thresholds in force.
    pub verdict: Verdict,
    /// Effects named under the thresholds in force.
    pub found: Vec<Found>,
    /// Evidence of every effect that was tried.
    pub candidates: Vec<Candidate>,
    /// Evidence at every port.
    pub ports: Vec<PortEvidence>,
    /// Why there is no answer.
    pub failure: Option<String>,
}

impl CalibrationTable {
    /// The table of these worlds.
    #[must_use]
    pub fn new(master_seed: u64, worlds: Vec<(Label, Answer)>) -> Self {
        let worlds = worlds
            .into_iter()
            .map(|(label, answer)| CalibrationWorld {
                label,
                verdict: answer.verdict,
                found: answer.found,
                candidates: answer.candidates,
                ports: answer.ports,
                failure: answer.failure,
            })
            .collect();
        Self { schema: SCHEMA.to_owned(), master_seed, worlds }
    }
}
