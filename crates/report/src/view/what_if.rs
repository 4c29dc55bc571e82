//! `what_if.json` and `what_if_constrained.json`: what twins answer to meals under other doses.
//!
//! ```json
//! {"schema": "what-if/1",
//!  "plan": {"carbs_g": [30.0], "ratios_g_per_u": [10.0, 20.0], "starts_mg_dl": [120.0, 90.0],
//!    "hours": [12, 7], "steps": 60},
//!  "curves": [{"carbs_g": 30.0, "ratio_g_per_u": 10.0, "minutes": [0.0, 5.0],
//!    "lower": [120.0, 121.2], "median": [120.0, 122.0], "upper": [120.0, 124.7]}],
//!  "order": [{"person_id": "...", "ordered": false, "worst_mg_dl": 6.4,
//!    "worst_at": "30 g at 180 mg/dL and 7 h, 20 against 10 g/U", "peaks_grow_with_meals": true}]}
//! ```

use serde::Deserialize;

use super::lenient::lenient;
use crate::{Part, ReportError};

/// Answers of twins to meals under other doses, and whether they are in order.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct WhatIf {
    /// Under which circumstances.
    #[serde(default, deserialize_with = "lenient")]
    pub plan: Option<WhatIfPlan>,
    /// One curve a meal and ratio, over people, at the plan's first glucose and hour.
    #[serde(default)]
    pub curves: Vec<WhatIfCurve>,
    /// One entry a twin.
    #[serde(default)]
    pub order: Vec<WhatIfOrder>,
}

/// The circumstances in which every meal was taken with every ratio.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct WhatIfPlan {
    /// Glucose at the meal, mg/dL; curves are shown of the first.
    pub starts_mg_dl: Vec<f64>,
    /// Hours of the day; curves are shown of the first.
    pub hours: Vec<u32>,
}

/// Quartiles of glucose over people after a meal with its bolus, mg/dL.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct WhatIfCurve {
    /// The meal, g.
    pub carbs_g: f64,
    /// Insulin-to-carbohydrate ratio, g/U: the higher, the less insulin.
    pub ratio_g_per_u: f64,
    /// Minutes since the meal.
    pub minutes: Vec<f64>,
    /// First quartile.
    pub lower: Vec<Option<f64>>,
    /// Median.
    pub median: Vec<Option<f64>>,
    /// Third quartile.
    pub upper: Vec<Option<f64>>,
}

/// Whether one twin answers in the right order.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct WhatIfOrder {
    /// The person.
    pub person_id: String,
    /// Whether less insulin never means less glucose, beyond what a sensor resolves, and mean glucose
    /// grows from each ratio to the next. Where this does not hold the twin is not to be used for
    /// what-ifs.
    pub ordered: bool,
    /// The most by which a curve with less insulin lies below one with more, mg/dL.
    pub worst_mg_dl: Option<f64>,
    /// Where that was, in words; empty where nothing is out of order.
    #[serde(default)]
    pub worst_at: String,
    /// Whether the peak grows with the meal at every ratio.
    #[serde(default)]
    pub peaks_grow_with_meals: Option<bool>,
}

impl WhatIf {
    /// Checks that all quartiles fit their minutes; `part` is the file that holds them.
    pub(crate) fn check(&self, part: Part) -> Result<(), ReportError> {
        for curve in &self.curves {
            for (series, values) in
                [("lower", &curve.lower), ("median", &curve.median), ("upper", &curve.upper)]
            {
                if values.len() != curve.minutes.len() {
                    return Err(ReportError::UnevenSeries {
                        part,
                        series,
                        found: values.len(),
                        of: "minutes",
                        expected: curve.minutes.len(),
                    });
                }
            }
        }
        Ok(())
    }
}
