//! What the checks found.

use physiology::NonFinite;
use serde::{Deserialize, Serialize};

/// A check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Check {
    /// No insulin for a day.
    ZeroInsulin,
    /// Multiples of the basal rate at rest, for a day.
    Basal,
    /// Boluses without food, U.
    Bolus,
    /// Meals without a bolus, g.
    Carbs,
    /// One meal at several carbohydrate ratios, g/U.
    CarbRatio,
}

/// What one check found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// The check.
    pub check: Check,
    /// Whether no case is worse than the tolerance.
    pub passed: bool,
    /// By how much the worst case misses what is asked, mg/dL; negative where even it has room.
    pub worst_mg_dl: f64,
    /// The worst case.
    pub worst: WorstCase,
    /// Comparisons made.
    pub cases: usize,
}

/// Where a check comes nearest to failing, or fails most.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WorstCase {
    /// Glucose at rest from which the runs start, mg/dL.
    pub start_mg_dl: f64,
    /// The rung below, in the unit of the check's doses.
    pub less: f64,
    /// The rung above.
    pub more: f64,
    /// Minutes from the dose.
    pub minutes: f64,
    /// Glucose on the rung below, mg/dL.
    pub glucose_less_mg_dl: f64,
    /// Glucose on the rung above, mg/dL.
    pub glucose_more_mg_dl: f64,
}

/// One run of a ladder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rung {
    /// The check it belongs to.
    pub check: Check,
    /// Glucose at rest, mg/dL.
    pub start_mg_dl: f64,
    /// The dose, in the unit of the check.
    pub dose: f64,
    /// Glucose at the end, mg/dL.
    pub end_mg_dl: f64,
    /// Of the reference.
    pub reference_end_mg_dl: f64,
    /// Lowest and highest glucose on the way, mg/dL.
    pub range_mg_dl: [f64; 2],
}

/// All checks of one model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BehaviourReport {
    /// Whether every check passed.
    pub passed: bool,
    /// The checks.
    pub findings: Vec<Finding>,
    /// Every run.
    pub rungs: Vec<Rung>,
    /// Starting values at which the model has no steady state, mg/dL; the nearest state was used.
    pub starts_not_at_rest: Vec<f64>,
}

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
