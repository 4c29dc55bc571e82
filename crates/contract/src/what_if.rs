//! `what_if.json` and `what_if_constrained.json`: what twins answer to meals under other doses.

use crate::document::even;
use crate::{ContractError, Document};

/// Which meals, doses and circumstances.
#[apply(strict!)]
pub struct WhatIfPlan {
    /// Meals, g.
    pub carbs_g: Vec<f64>,
    /// Insulin-to-carbohydrate ratios, g/U, ascending: less insulin from one to the next.
    pub ratios_g_per_u: Vec<f64>,
    /// Glucose at the meal, mg/dL; the first is shown as curves.
    pub starts_mg_dl: Vec<f64>,
    /// Hours of the day, 0 to 23; the first is shown as curves.
    pub hours: Vec<u8>,
    /// Steps that a run lasts.
    pub steps: usize,
}

/// `what_if.json`.
#[apply(strict!)]
pub struct WhatIf {
    /// `what-if/1`.
    pub schema: String,
    /// What was asked.
    pub plan: WhatIfPlan,
    /// One curve a meal and ratio, over people, at the first glucose and hour.
    pub curves: Vec<WhatIfCurve>,
    /// One entry a person.
    pub order: Vec<WhatIfOrder>,
}

/// Glucose over people, one value a step from the meal on, mg/dL.
#[apply(strict!)]
pub struct WhatIfCurve {
    /// The meal, g.
    pub carbs_g: f64,
    /// The ratio, g/U.
    pub ratio_g_per_u: f64,
    /// Minutes since the meal.
    pub minutes: Vec<f64>,
    /// First quartile.
    pub lower: Vec<f64>,
    /// Median.
    pub median: Vec<f64>,
    /// Third quartile.
    pub upper: Vec<f64>,
}

/// Whether one twin answers in the right order.
#[apply(strict!)]
pub struct WhatIfOrder {
    /// The person.
    pub person_id: String,
    /// Whether less insulin never means less glucose: at no step of any run is the curve of a higher
    /// ratio below that of a lower one by more than 0.5 mg/dL, and mean glucose
    /// grows from each ratio to the next. Where this does not hold the twin is not to be used for
    /// what-ifs.
    pub ordered: bool,
    /// The most by which a curve with less insulin lies below one with more, mg/dL.
    pub worst_mg_dl: f64,
    /// Where that was, in words; empty where nothing is out of order.
    pub worst_at: String,
    /// Whether the peak grows with the meal at every ratio. A network may break this and still be
    /// of use for doses.
    pub peaks_grow_with_meals: bool,
}

impl WhatIfOrder {
    /// By how much a curve with less insulin may lie below one with more, mg/dL.
    pub const SAME_MG_DL: f64 = 0.5;
}

impl Document for WhatIf {
    const FILE: &'static str = "what_if.json";
    const SCHEMA: &'static str = "what-if/1";

    fn check(&self) -> Result<(), ContractError> {
        self.curves.iter().try_for_each(|curve| {
            let series = [
                ("lower", curve.lower.len()),
                ("median", curve.median.len()),
                ("upper", curve.upper.len()),
            ];
            even(Self::FILE, ("minutes", curve.minutes.len()), series)
        })
    }
}
