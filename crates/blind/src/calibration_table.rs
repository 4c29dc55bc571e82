//! The table that sets the thresholds: `calibration.json`, schema `calibration/2`.

use contract::Document as _;
use contract::blind_check::{Answer, CalibrationTable, CalibrationWorld, Label};

/// The table of these worlds.
#[must_use]
pub fn calibration_table(master_seed: u64, worlds: Vec<(Label, Answer)>) -> CalibrationTable {
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
    CalibrationTable { schema: CalibrationTable::SCHEMA.to_owned(), master_seed, worlds }
}
