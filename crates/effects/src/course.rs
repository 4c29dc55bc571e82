//! What a driver may look at: a person's record and filtered glucose, step by step.

/// Length of a step, min.
pub const STEP_MINUTES: f64 = 5.0;
/// Steps of a day.
const STEPS_PER_DAY: usize = 288;
/// Share of steps with a value below which a channel counts as never recorded.
const LEAST_SHARE: f64 = 0.2;

/// One person's time courses; every list has one entry per five-minute step.
///
/// A channel that was never recorded is `None` as a whole; gaps inside a channel are `None` entries.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Course {
    /// Local hour of the day at the start of the step, 0 to below 24.
    pub hour: Vec<f64>,
    /// Calendar day, counted from that of the first step.
    pub day: Vec<usize>,
    /// Saturday or Sunday.
    pub weekend: Vec<bool>,
    /// Carbohydrate logged, g; 0 where none or not recorded.
    pub carbs: Vec<f64>,
    /// Bolus insulin logged, U; 0 where none or not recorded.
    pub bolus: Vec<f64>,
    /// Heart rate over rest, 1/min.
    pub heart_rate_over_rest: Option<Vec<Option<f64>>>,
    /// Steps walked.
    pub walked: Option<Vec<Option<f64>>>,
    /// Share of the step asleep, 0 to 1.
    pub asleep: Option<Vec<Option<f64>>>,
    /// Whether an infusion set was changed in the step.
    pub set_changed: Option<Vec<bool>>,
    /// Plasma glucose as the filter sees it after the step's reading, mg/dL. Smooth where readings are
    /// noisy; a driver built on readings themselves would be correlated with their noise.
    pub glucose: Vec<f64>,
    /// Age of the glucose sensor, days, where its insertion can be told from gaps in the readings.
    pub sensor_age: Option<Vec<f64>>,
}

impl Course {
    /// Number of steps.
    #[must_use]
    pub fn len(&self) -> usize {
        self.hour.len()
    }

    /// A function of the hour at every step. Hours come round, so that it is mostly that of the day before.
    pub fn by_hour<'a>(&'a self, of: impl Fn(f64) -> f64 + 'a) -> impl Iterator<Item = f64> + 'a {
        let first = self.hour.iter().take(STEPS_PER_DAY);
        let day: Vec<(f64, f64)> = first.map(|hour| (*hour, of(*hour))).collect();
        self.hour.iter().enumerate().map(move |(step, hour)| {
            let (same, value) = day[step % STEPS_PER_DAY];
            // Hours are worked out from the number of the step and differ by rounding.
            if (same - hour).abs() < 1e-9 { value } else { of(*hour) }
        })
    }

    /// Whether there is no step.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.hour.is_empty()
    }
}

/// The value of a channel in a step; `None` in a gap and where it was never recorded.
pub(crate) fn value_at(channel: Option<&Vec<Option<f64>>>, step: usize) -> Option<f64> {
    channel?.get(step).copied().flatten()
}

/// Whether at least a fifth of the steps have a value.
pub(crate) fn recorded<T>(channel: Option<&Vec<Option<T>>>) -> bool {
    channel.is_some_and(|values| {
        let present = values.iter().filter(|value| value.is_some()).count();
        present > 0 && present as f64 >= LEAST_SHARE * values.len() as f64
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_of_the_hour_is_that_of_each_steps_hour() {
        let hour = |k: usize| (21.5 + k as f64 / 12.0) % 24.0;
        let mut hours: Vec<f64> = (0..700).map(hour).collect();
        // A clock that was set by an hour does not come round.
        hours[400..].iter_mut().for_each(|hour| *hour = (*hour + 1.0) % 24.0);
        let course = Course { hour: hours.clone(), ..Course::default() };
        for (found, hour) in course.by_hour(|hour| hour * hour).zip(&hours) {
            assert!((found - hour * hour).abs() < 1e-7, "{found} at {hour}"); // rounding of the hour
        }
        assert_eq!(Course::default().by_hour(f64::exp).count(), 0);
    }

    #[test]
    fn a_fifth_is_enough_and_less_is_not() {
        let with = |present: usize| -> Vec<Option<f64>> {
            (0..100).map(|k| (k < present).then_some(1.0)).collect()
        };
        assert!(recorded(Some(&with(20))));
        assert!(!recorded(Some(&with(19))));
        assert!(!recorded(Some(&Vec::<Option<f64>>::new())));
        assert!(!recorded::<f64>(None));
    }
}
