//! Centring a driver across days within each clock slot.
//!
//! A driver that is not about the clock (how old the infusion set is, how long the night was) still
//! carries clock time: it is non-zero at some hours more than at others. Left so, it borrows the gap of
//! whatever does follow the clock. What is left after centring is only the difference between days.

use crate::course::Course;

/// Slots of five minutes in a day.
const SLOTS: usize = 288;
/// Slots in an hour.
const SLOTS_PER_HOUR: f64 = 12.0;

/// Subtracts from each value the mean of all known values in the same five-minute slot of the clock.
///
/// `values` has one entry a step of `course`; what is unknown stays out of the mean and becomes 0, the
/// value that changes nothing. The mean looks at the whole record, so a centred driver is the one
/// place where a later day reaches an earlier one: as a constant of the slot, never as an event.
#[must_use]
pub fn centre_within_clock_slots(course: &Course, values: &[Option<f64>]) -> Vec<f64> {
    let slots: Vec<usize> = course.hour.iter().map(|hour| slot(*hour)).collect();
    let mut means = [0.0_f64; SLOTS];
    let mut counts = [0.0_f64; SLOTS];
    for (slot, value) in slots.iter().zip(values) {
        if let Some(value) = value {
            means[*slot] += value;
            counts[*slot] += 1.0;
        }
    }
    for (mean, count) in means.iter_mut().zip(&counts) {
        *mean /= count.max(1.0);
    }
    let known = slots.iter().zip(values);
    known.map(|(slot, value)| value.map_or(0.0, |value| value - means[*slot])).collect()
}

/// Slot of an hour of the day.
fn slot(hour: f64) -> usize {
    (hour * SLOTS_PER_HOUR).round() as usize % SLOTS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_of_the_clock_vanishes_and_a_difference_between_days_stays() {
        let hour: Vec<f64> = (0..3 * SLOTS).map(|k| (k % SLOTS) as f64 / SLOTS_PER_HOUR).collect();
        let course = Course { hour, ..Course::default() };
        let clock: Vec<Option<f64>> = course.hour.iter().map(|h| Some(h.sin())).collect();
        // Three equal values less their mean: rounding only.
        assert!(centre_within_clock_slots(&course, &clock).iter().all(|v| v.abs() < 1e-12));

        let day: Vec<Option<f64>> =
            (0..3 * SLOTS).map(|k| (k / SLOTS < 2).then_some((k / SLOTS) as f64)).collect();
        let centred = centre_within_clock_slots(&course, &day);
        assert_eq!((centred[5], centred[SLOTS + 5], centred[2 * SLOTS + 5]), (-0.5, 0.5, 0.0));
    }
}
