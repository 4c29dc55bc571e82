//! The range of one coordinate.

use crate::error::SearchError;

/// The closed range of one coordinate, in its own unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    low: f64,
    high: f64,
}

impl Range {
    /// The numbers from `low` to `high`.
    ///
    /// # Errors
    /// [`SearchError::Range`] unless both are finite and `low` is below `high`.
    pub fn new(low: f64, high: f64) -> Result<Self, SearchError> {
        if low < high && low.is_finite() && high.is_finite() {
            Ok(Self { low, high })
        } else {
            Err(SearchError::Range { low, high })
        }
    }

    /// The numbers from 0 to 1.
    pub(crate) const fn unit() -> Self {
        Self { low: 0.0, high: 1.0 }
    }

    /// The value at a share of the range, 0 at its lower end.
    pub(crate) fn at(self, share: f64) -> f64 {
        (self.low + share * (self.high - self.low)).clamp(self.low, self.high)
    }

    /// The share of the range below a value.
    pub(crate) fn share(self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }
}
