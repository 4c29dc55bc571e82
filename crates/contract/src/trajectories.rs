//! `trajectories.json`: whether a model answers to doses as a person does.

/// All checks of one model.
#[apply(strict!)]
pub struct Trajectories {
    /// The checks.
    pub findings: Vec<Finding>,
    /// Whether every check passed.
    pub passed: bool,
    /// Every run.
    pub rungs: Vec<Rung>,
    /// `trajectories/1`.
    pub schema: String,
    /// Starting values at which the model has no steady state, mg/dL; the nearest state was used.
    pub starts_not_at_rest: Vec<f64>,
}

/// A check.
#[apply(word!)]
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
#[apply(strict!)]
pub struct Finding {
    /// Comparisons made.
    pub cases: usize,
    /// The check.
    pub check: Check,
    /// Whether no case is worse than the tolerance.
    pub passed: bool,
    /// The worst case.
    pub worst: WorstCase,
    /// By how much the worst case misses what is asked, mg/dL; negative where even it has room.
    pub worst_mg_dl: f64,
}

/// Where a check comes nearest to failing, or fails most.
#[apply(strict!)]
#[derive(Copy)]
pub struct WorstCase {
    /// Glucose on the rung below, mg/dL.
    pub glucose_less_mg_dl: f64,
    /// Glucose on the rung above, mg/dL.
    pub glucose_more_mg_dl: f64,
    /// The rung below, in the unit of the check's doses.
    pub less: f64,
    /// Minutes from the dose.
    pub minutes: f64,
    /// The rung above.
    pub more: f64,
    /// Glucose at rest from which the runs start, mg/dL.
    pub start_mg_dl: f64,
}

/// One run of a ladder.
#[apply(strict!)]
pub struct Rung {
    /// The check it belongs to.
    pub check: Check,
    /// The dose, in the unit of the check.
    pub dose: f64,
    /// Glucose at the end, mg/dL.
    pub end_mg_dl: f64,
    /// Lowest and highest glucose on the way, mg/dL.
    pub range_mg_dl: [f64; 2],
    /// Glucose at the end under the reference, mg/dL.
    pub reference_end_mg_dl: f64,
    /// Glucose at rest, mg/dL.
    pub start_mg_dl: f64,
}
