//! Steps of five minutes, counted from 1970.

use chrono::{DateTime, NaiveDateTime};

/// Seconds of a step.
pub(super) const STEP: i64 = 300;

/// The steps of a record: the first, and one past the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) first: i64,
    pub(super) end: i64,
}

impl Span {
    pub(super) fn len(self) -> usize {
        usize::try_from(self.end - self.first).unwrap_or(0)
    }

    /// The step of the record; `None` outside.
    pub(super) fn index(self, step: i64) -> Option<usize> {
        (self.first..self.end).contains(&step).then(|| usize::try_from(step - self.first).ok())?
    }
}

/// The step that holds a second.
pub(super) fn step_of(second: i64) -> i64 {
    second.div_euclid(STEP)
}

/// Start of a step.
pub(super) fn time_of(step: i64) -> NaiveDateTime {
    DateTime::from_timestamp(step * STEP, 0).unwrap_or_default().naive_utc()
}
