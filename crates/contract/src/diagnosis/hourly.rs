//! The gap through the day, by situation and by person.

use serde::{Deserialize, Serialize};

/// The gap by time of day, crossed with situations and with people.
///
/// It is there to be looked at: the verdict, `where` and their family-wise error rate do not depend on it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct HourlyGap {
    /// Length of the free runs, min.
    pub horizon_minutes: u32,
    /// Parts of the day, `HH-HH`, by the clock halfway through a run.
    pub parts: Vec<String>,
    /// `all`, the cells of `where`, then each situation that anybody was in. Intervals of situations hold for all of them
    /// together in 95 of 100, those of `all` with the rest of `where`.
    pub situations: Vec<HourlyRow>,
    /// Each person who was diagnosed, in the order of the cohort. Intervals hold for all people together in 95 of 100.
    pub people: Vec<HourlyRow>,
}

/// One situation or person through the day.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct HourlyRow {
    /// The situation, e.g. `after_meal`, or the person.
    pub name: String,
    /// One entry a part of the day; `None` where too few runs lie in it.
    pub cells: Vec<Option<HourlyCell>>,
}

/// The gap in one part of the day.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct HourlyCell {
    /// Mean error of free runs, observed minus predicted, mg/dL: positive where the plant under-predicts glucose. The
    /// mean over people of each person's mean.
    pub mean_error_mg_dl: f64,
    /// Lower end of the simultaneous interval.
    pub lower: f64,
    /// Upper end of the simultaneous interval.
    pub upper: f64,
    /// People who contribute.
    pub people: usize,
    /// Free runs that contribute.
    pub runs: usize,
}

impl HourlyCell {
    /// Whether the interval leaves 0 out.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.lower > 0.0 || self.upper < 0.0
    }
}
