//! A person's heart rate at rest, the reference of the heart-rate input.
//!
//! The paper takes "the average heart rate during periods of rest, when no exercise was being
//! performed" (section on the individual-level model). Free-living records seldom mark exercise, so
//! rest is read from the step counter, or from the heart rate itself where there is none.

use physiology::{BeatsPerMinute, STEPS_PER_DAY, STEPS_PER_HOUR};

use crate::person::Person;
use crate::split::TRAINING_DAYS;

/// Fewest resting steps for the step-counter rule: one hour.
const FEWEST_STEPS: usize = STEPS_PER_HOUR;
/// Length of the time without walking before a step: half an hour.
const STILL_BEFORE: usize = STEPS_PER_HOUR / 2;

impl Person {
    /// Heart rate at rest: the given baseline (0 where the source gives differences from it), or else an estimate from
    /// the first 14 days that have heart rates: where as many days train, held-out days do not enter. That is the mean over steps of five
    /// minutes without walking, also in the half hour before, or, where too few steps have a step count, of the values
    /// at or below their median. `None` if no heart rate is recorded.
    #[must_use]
    pub fn resting_heart_rate(&self) -> Option<BeatsPerMinute> {
        if self.heart_rate_baseline.is_some() {
            return self.heart_rate_baseline;
        }
        let heart_rate = self.record.heart_rate();
        let first = heart_rate.iter().position(Option::is_some)?;
        let end = heart_rate.len().min(first + TRAINING_DAYS * STEPS_PER_DAY);

        let steps = self.record.steps();
        let still = |k: usize| {
            k >= STILL_BEFORE && steps[k - STILL_BEFORE..=k].iter().all(|count| *count == Some(0.0))
        };
        let resting: Vec<f64> =
            (first..end).filter(|&k| still(k)).filter_map(|k| heart_rate[k]).collect();
        if resting.len() >= FEWEST_STEPS {
            return Some(mean(&resting));
        }
        let mut values: Vec<f64> = heart_rate[first..end].iter().copied().flatten().collect();
        values.sort_by(f64::total_cmp);
        values.truncate(values.len().div_ceil(2));
        Some(mean(&values))
    }
}

fn mean(values: &[f64]) -> BeatsPerMinute {
    BeatsPerMinute(values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Channel, Record, Therapy};

    fn person(len: usize, fill: impl Fn(usize) -> (Option<f64>, Option<f64>)) -> Person {
        let start = "2024-03-08T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, len).expect("on the grid");
        for k in 0..len {
            let (rate, steps) = fill(k);
            record.channel_mut(Channel::HeartRate)[k] = rate;
            record.channel_mut(Channel::Steps)[k] = steps;
        }
        Person {
            id: "a".into(),
            weight: None,
            therapy: Therapy::Unknown,
            heart_rate_baseline: None,
            record,
        }
    }

    #[test]
    fn rest_is_half_an_hour_without_steps() {
        // Walking at steps 0 to 9, and not yet at rest for the half hour after: 90; then 60.
        let person = person(40, |k| {
            (Some(if k < 16 { 90.0 } else { 60.0 }), Some(if k < 10 { 50.0 } else { 0.0 }))
        });
        assert_eq!(person.resting_heart_rate(), Some(BeatsPerMinute(60.0)));
    }

    #[test]
    fn without_a_step_counter_the_lower_half_counts() {
        let person = person(5, |k| (Some(60.0 + 10.0 * k as f64), None));
        assert_eq!(person.resting_heart_rate(), Some(BeatsPerMinute(70.0)));
    }

    #[test]
    fn held_out_days_do_not_enter_and_a_given_baseline_stands() {
        let boundary = TRAINING_DAYS * STEPS_PER_DAY;
        let mut person =
            person(boundary + 288, |k| (Some(if k < boundary { 60.0 } else { 30.0 }), Some(0.0)));
        assert_eq!(person.resting_heart_rate(), Some(BeatsPerMinute(60.0)));
        person.heart_rate_baseline = Some(BeatsPerMinute(0.0));
        assert_eq!(person.resting_heart_rate(), Some(BeatsPerMinute(0.0)));
    }

    #[test]
    fn no_heart_rate_no_baseline() {
        assert_eq!(person(10, |_| (None, Some(0.0))).resting_heart_rate(), None);
    }
}
