//! `development-set.json` and `scaler.json`: the simulated development set.

use std::collections::BTreeMap;

/// What the development set consists of.
#[apply(strict!)]
pub struct DevelopmentSetSummary {
    /// Columns of the rows, in their order.
    pub columns: Vec<ColumnUnit>,
    /// SHA-256 of the rows, hexadecimal.
    pub data_sha256: String,
    /// Days that are simulated.
    pub days: usize,
    /// Files of rows.
    pub files: usize,
    /// Daily meal scenarios that lie in two subsets; always 0.
    pub meal_days_in_two_subsets: usize,
    /// Rows of all files.
    pub rows: usize,
    /// `development-set/1`.
    pub schema: String,
    /// Length of a step, min.
    pub step_minutes: f64,
    /// Training, validation and test.
    pub subsets: BTreeMap<String, SubsetSummary>,
    /// Weeks that are simulated.
    pub weeks: usize,
    /// Steps of a window.
    pub window_steps: usize,
}

/// A column and its unit.
#[apply(strict!)]
pub struct ColumnUnit {
    /// Its name.
    pub name: String,
    /// Its unit; empty where dimensionless.
    pub unit: String,
}

/// One subset of the development set.
#[apply(strict!)]
#[derive(Copy)]
pub struct SubsetSummary {
    /// Weeks that were added for high glucose.
    pub additional_high: usize,
    /// Weeks that were added for low glucose.
    pub additional_low: usize,
    /// Weeks of the combinations of meals, starts, delays and doses.
    pub combinations: usize,
    /// Daily meal scenarios from which its weeks are drawn.
    pub meal_days: usize,
    /// Mean share of steps above 250 mg/dL, 0 to 1.
    pub share_above_250: f64,
    /// Mean share of steps below 70 mg/dL, 0 to 1.
    pub share_below_70: f64,
    /// Weeks.
    pub weeks: usize,
    /// Windows that do not overlap.
    pub windows_apart: usize,
    /// Windows as training takes them.
    pub windows_overlapping: usize,
}

/// Centre and scale of each signal: `scaled = (physical - centre) / scale`.
#[apply(strict!)]
pub struct ScalerSummary {
    /// What the centre is, in words.
    pub centre_is: String,
    /// SHA-256 of the rows of the development set, hexadecimal.
    pub data_sha256: String,
    /// What the scale is, in words.
    pub scale_is: String,
    /// `scaler/1`.
    pub schema: String,
    /// By signal.
    pub signals: BTreeMap<String, SignalScale>,
    /// Rows behind them.
    pub training_rows: usize,
}

/// Centre and scale of one signal.
#[apply(strict!)]
pub struct SignalScale {
    /// The physical value that is scaled to 0, in `unit`.
    pub centre: f64,
    /// The physical length that is scaled to 1, in `unit`.
    pub scale: f64,
    /// The unit.
    pub unit: String,
}
