//! The part of a diagnosis that is scored.

use contract::Diagnosis;
use contract::blind_check::{Answer, Verdict};

/// The answer of a diagnosis that took `seconds`.
#[must_use]
pub fn answer(diagnosis: Diagnosis, seconds: f64) -> Answer {
    Answer {
        verdict: match diagnosis.verdict {
            contract::diagnosis::Verdict::None => Verdict::None,
            contract::diagnosis::Verdict::Effect => Verdict::Effect,
            contract::diagnosis::Verdict::Unknown => Verdict::Unknown,
        },
        found: diagnosis.effects,
        candidates: diagnosis.candidates,
        ports: diagnosis.ports,
        cells: diagnosis.cells,
        failure: None,
        seconds,
    }
}
