//! Training and held-out parts of a record.

use std::ops::Range;

use physiology::STEPS_PER_DAY;

use crate::record::Record;

/// Days a twin is trained on: the first two weeks (paper, section on the individual-level model).
pub const TRAINING_DAYS: usize = 14;

/// A record split in time. Windows inside either range never cross the boundary.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimeSplit {
    /// The training steps.
    pub train: Range<usize>,
    /// The held-out steps; empty if the record is no longer than the training days.
    pub test: Range<usize>,
}

/// Splits a record `days` times 24 hours after its first step.
#[must_use]
pub fn split_by_time(record: &Record, days: usize) -> TimeSplit {
    let boundary = days.saturating_mul(STEPS_PER_DAY).min(record.len());
    TimeSplit { train: 0..boundary, test: boundary..record.len() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_days_train_and_the_rest_tests() {
        let start = "2024-03-08T07:25:00".parse().expect("a literal time");
        let record = Record::new(start, 20 * 288 + 5).expect("on the grid");
        let split = split_by_time(&record, TRAINING_DAYS);
        assert_eq!((split.train, split.test), (0..4032, 4032..5765));
        let short = split_by_time(&record, 100);
        assert_eq!((short.train, short.test), (0..5765, 5765..5765));
    }
}
