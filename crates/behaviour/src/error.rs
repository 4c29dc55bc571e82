//! Why the checks could not be made.

use contract::trajectories::Check;
use physiology::NonFinite;

/// Why the checks could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BehaviourError {
    /// There is no state to start from.
    #[error("{who} cannot be started at {glucose_mg_dl} mg/dL: {reason}")]
    NoStart {
        /// `the model` or `the reference`.
        who: &'static str,
        /// Glucose asked for, mg/dL.
        glucose_mg_dl: f64,
        /// What its search said.
        reason: String,
    },
    /// A run left the finite numbers.
    #[error(
        "{who} left the finite numbers {minutes} min after the start at {glucose_mg_dl} mg/dL: {source}"
    )]
    NotFinite {
        /// `the model` or `the reference`.
        who: &'static str,
        /// Glucose at the start, mg/dL.
        glucose_mg_dl: f64,
        /// Minutes from the start.
        minutes: f64,
        /// The compartment.
        source: NonFinite,
    },
    /// A rule that cannot be checked.
    #[error("the ladder of {check:?} needs two or more ascending doses")]
    Ladder {
        /// The check.
        check: Check,
    },
}
