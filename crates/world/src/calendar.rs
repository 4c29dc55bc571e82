//! Local wall-clock time of the steps of a record.

use std::ops::Range;

use chrono::{Datelike, NaiveDate, NaiveDateTime, TimeDelta};
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

/// A record of whole days that starts at midnight.
///
/// Steps are counted from 0 at the first midnight. There is no daylight saving.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Calendar {
    start: NaiveDate,
    days: usize,
}

impl Calendar {
    /// `days` days from midnight of `start`.
    #[must_use]
    pub fn new(start: NaiveDate, days: usize) -> Self {
        Self { start, days }
    }

    /// The first day.
    #[must_use]
    pub fn start(&self) -> NaiveDate {
        self.start
    }

    /// Number of days.
    #[must_use]
    pub fn days(&self) -> usize {
        self.days
    }

    /// Number of five-minute steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.days * STEPS_PER_DAY
    }

    /// Start of a step, local wall clock.
    #[must_use]
    pub fn time(&self, step: usize) -> NaiveDateTime {
        self.start.and_time(chrono::NaiveTime::MIN) + TimeDelta::minutes(5 * step as i64)
    }

    /// Hour of the day at the start of a step, 0 to below 24 with its fraction.
    #[must_use]
    pub fn hour(&self, step: usize) -> f64 {
        (step % STEPS_PER_DAY) as f64 / STEPS_PER_HOUR as f64
    }

    /// Whether day `day` (counted from 0) is a Saturday or Sunday.
    #[must_use]
    pub fn is_weekend(&self, day: usize) -> bool {
        self.weekday(day) >= 5
    }

    /// Days since Monday of day `day` (counted from 0): 0 for Monday to 6 for Sunday.
    #[must_use]
    pub fn weekday(&self, day: usize) -> usize {
        (self.start.weekday().num_days_from_monday() as usize + day) % 7
    }

    /// The step nearest to `hour` of day `day`, if the record holds it. `hour` may lie outside
    /// 0 to 24: -1 is an hour before midnight.
    #[must_use]
    pub fn step_at(&self, day: usize, hour: f64) -> Option<usize> {
        let step = self.signed_step(day, hour);
        usize::try_from(step).ok().filter(|s| *s < self.steps())
    }

    /// As [`Self::step_at`], but also outside the record.
    #[must_use]
    pub fn signed_step(&self, day: usize, hour: f64) -> i64 {
        (day * STEPS_PER_DAY) as i64 + (hour * STEPS_PER_HOUR as f64).round() as i64
    }
}

/// The part of a range of steps that lies within a record of so many steps.
pub(crate) fn within(range: Range<i64>, steps: usize) -> Range<usize> {
    let clamped = |step: i64| usize::try_from(step).unwrap_or(0).min(steps);
    clamped(range.start)..clamped(range.end).max(clamped(range.start))
}

/// Days from the last of these changes, in order of their steps, to a step; 0 before the first.
pub(crate) fn days_since_last(changes: &[i64], step: usize) -> f64 {
    let step = step as i64;
    let past = changes.partition_point(|change| *change <= step);
    let since = changes.get(past.saturating_sub(1)).copied().unwrap_or(step);
    (step - since).max(0) as f64 / STEPS_PER_DAY as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_carry_time_weekday_and_hour() {
        let monday = NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date");
        let calendar = Calendar::new(monday, 7);
        assert_eq!(calendar.steps(), 2016);
        assert_eq!(calendar.time(STEPS_PER_DAY + 1).to_string(), "2024-01-09 00:05:00");
        assert!(!calendar.is_weekend(4) && calendar.is_weekend(5) && calendar.is_weekend(6));
        assert_eq!(calendar.step_at(1, 7.5), Some(STEPS_PER_DAY + 90));
        assert_eq!(calendar.step_at(0, -1.0), None);
        assert_eq!(calendar.step_at(6, 24.0), None);
        assert!((calendar.hour(STEPS_PER_DAY + 90) - 7.5).abs() < 1e-12); // one rounding
    }
}
