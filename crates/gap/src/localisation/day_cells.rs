//! What is tested, and by which rule.

use serde::{Deserialize, Serialize};

use crate::error::{GapError, require};

/// Cells, resampling and levels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LocalisationRule {
    /// Horizon, steps, of the free runs that are averaged by hour, situation, band and person.
    pub horizon: usize,
    /// Family-wise error rate of the whole diagnosis: intervals cover jointly with 1 minus this.
    pub error_rate: f64,
    /// Bootstrap replicates.
    pub replicates: usize,
    /// Consecutive days that count as one unit.
    pub block_days: usize,
    /// Errors that a person must have in a cell to count in it.
    pub fewest_errors: usize,
    /// Days with errors that a person must have in a cell to count in it.
    pub fewest_days: usize,
}

impl LocalisationRule {
    /// The values in use: 60 min, 5 %, 2,000 replicates of 2-day blocks, at least 10 errors on 3 days.
    #[must_use]
    pub const fn working() -> Self {
        Self {
            horizon: 12,
            error_rate: 0.05,
            replicates: 2000,
            block_days: 2,
            fewest_errors: 10,
            fewest_days: 3,
        }
    }

    /// Checks that the settings can be.
    ///
    /// # Errors
    /// [`GapError::Setting`] naming the first that cannot.
    pub fn validated(self) -> Result<Self, GapError> {
        let settings = [
            ("replicates", self.replicates, 100, "at least 100"),
            ("block_days", self.block_days, 1, "at least 1"),
            ("fewest_errors", self.fewest_errors, 2, "at least 2"),
            ("fewest_days", self.fewest_days, 2, "at least 2"),
        ];
        for (name, value, least, requirement) in settings {
            require(value >= least, name, value as f64, requirement)?;
        }
        let rate = self.error_rate;
        require(rate > 0.0 && rate < 1.0, "error_rate", rate, "between 0 and 1")?;
        Ok(self)
    }
}

/// Errors of one person's day, one entry a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct DayCells {
    /// Number of errors in each cell.
    pub counts: Vec<f64>,
    /// Their sums.
    pub sums: Vec<f64>,
}

impl DayCells {
    /// A day without errors.
    #[must_use]
    pub fn empty(cells: usize) -> Self {
        Self { counts: vec![0.0; cells], sums: vec![0.0; cells] }
    }

    /// Counts one error in a cell.
    pub fn add(&mut self, cell: usize, error: f64) {
        self.counts[cell] += 1.0;
        self.sums[cell] += error;
    }
}
