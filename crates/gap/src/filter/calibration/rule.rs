//! How a calibration is run.

use serde::{Deserialize, Serialize};

/// How a calibration is run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CalibrationRule {
    /// Steps at the start of the record whose innovations are not scored.
    pub burn_in: usize,
    /// Steps after an unrecorded dose whose innovations are not scored.
    pub dose_memory: usize,
    /// Iterations after which the calibration gives up and says so.
    pub max_iterations: usize,
    /// The iteration ends when a step is no longer than this many posterior standard deviations, in whatever
    /// direction.
    pub tolerance: f64,
    /// Log factors are kept within plus and minus this, far beyond what bodies are: a guard for the plant, no prior.
    pub bound: f64,
}

impl CalibrationRule {
    /// The values in use: 12 h of burn-in, 4 h of dose memory, 30 iterations, 0.1 posterior standard
    /// deviations (which add a hundredth to the variance), factors within exp(-1.5) to exp(1.5).
    #[must_use]
    pub const fn working() -> Self {
        Self { burn_in: 144, dose_memory: 48, max_iterations: 30, tolerance: 0.1, bound: 1.5 }
    }
}
