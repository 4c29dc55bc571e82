//! What a day of the record adds up to.

use cohort::{Channel, Person};
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

/// Share of a day's steps that must be recorded for the day to count.
const RECORDED: f64 = 0.9;

/// Doses of one day of the record (288 steps from its start, not from midnight).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DayDoses {
    /// First step.
    pub(super) start: usize,
    /// Basal insulin, U.
    pub(super) basal: f64,
    /// Bolus insulin, U.
    pub(super) bolus: f64,
    /// Carbohydrate logged, g; `None` where it is not recorded.
    pub(super) carbs: Option<f64>,
}

impl DayDoses {
    /// Basal and bolus, U.
    pub(super) fn insulin(&self) -> f64 {
        self.basal + self.bolus
    }
}

/// The days on which basal and bolus are recorded nearly throughout. One of the two that is never
/// recorded counts as none; with neither there is no day.
pub(super) fn days(person: &Person) -> Vec<DayDoses> {
    let record = &person.record;
    let total = |channel: Channel, start: usize| {
        let values = record.channel(channel)[start..start + STEPS_PER_DAY].iter().flatten();
        let share = values.clone().count() as f64 / STEPS_PER_DAY as f64;
        (share >= RECORDED).then(|| values.sum::<f64>() / share)
    };
    let never = |channel| record.channel(channel).iter().all(Option::is_none);
    let (no_basal, no_bolus) = (never(Channel::Basal), never(Channel::Bolus));
    if no_basal && no_bolus {
        return Vec::new();
    }
    (0..record.len() / STEPS_PER_DAY)
        .filter_map(|day| {
            let start = day * STEPS_PER_DAY;
            Some(DayDoses {
                start,
                basal: if no_basal { 0.0 } else { total(Channel::Basal, start)? }
                    / STEPS_PER_HOUR as f64,
                bolus: if no_bolus { 0.0 } else { total(Channel::Bolus, start)? },
                carbs: total(Channel::Carbs, start),
            })
        })
        .collect()
}

/// The mean with a 95 % interval by Student's t; `None` with fewer than three values.
pub(super) fn mean_with_interval(values: &[f64]) -> Option<(f64, f64, f64)> {
    use statrs::distribution::{ContinuousCDF, StudentsT};
    let n = values.len() as f64;
    if values.len() < 3 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let t = StudentsT::new(0.0, 1.0, n - 1.0).ok()?.inverse_cdf(0.975);
    let half = t * (variance / n).sqrt();
    Some((mean, mean - half, mean + half))
}

/// The median with the 5th and the 95th percentile; `None` for no value.
pub(super) fn median_with_range(mut values: Vec<f64>) -> Option<(f64, f64, f64)> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some((values[values.len() / 2], values[last * 5 / 100], values[last * 95 / 100]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_students() {
        // Mean 3, SD 1.5811, t(0.975; 4) = 2.7764 from printed tables: half-width 1.9632.
        let (mean, lower, upper) =
            mean_with_interval(&[1.0, 2.0, 3.0, 4.0, 5.0]).expect("five values");
        assert_eq!(mean, 3.0);
        assert!((upper - 4.9632).abs() < 1e-4 && (lower - 1.0368).abs() < 1e-4, "{lower} {upper}");
        assert_eq!(mean_with_interval(&[1.0, 2.0]), None);
    }

    #[test]
    fn days_are_scaled_to_what_was_recorded_and_short_ones_dropped() {
        let mut person = crate::quality::tests::person_with(Channel::Bolus, &[6.0]);
        person.record.channel_mut(Channel::Basal).fill(Some(1.2));
        person.record.channel_mut(Channel::Basal)[STEPS_PER_DAY..STEPS_PER_DAY + 30].fill(None);
        let found = days(&person);
        assert_eq!(found.len(), 13);
        assert!((found[0].insulin() - 34.8).abs() < 1e-9 && found[0].carbs.is_none());
        // Never recorded is none given; neither recorded is no day.
        person.record.channel_mut(Channel::Basal).fill(None);
        assert_eq!(days(&person).len(), 14);
        person.record.channel_mut(Channel::Bolus).fill(None);
        assert_eq!(days(&person), []);
    }
}
