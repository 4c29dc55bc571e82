//! `heart_rate_alignment`: a heart rate that does not keep the person's hours.
//!
//! The heart beats 10 to 20 a minute slower in the night than in the day, and faster when its owner
//! walks. A heart rate without a day-night difference, or one that follows the step count by hours,
//! lies on another clock (the five-minute heart rate of T1D-UOM does), and exercise read from it would
//! fall at random times.

use cohort::{Channel, Person};
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::daily_doses::mean_with_interval;
use super::{Consequence, Finding};

/// Hours that count as night and as day.
const NIGHT: std::ops::Range<u8> = 0..6;
const DAY: std::ops::Range<u8> = 10..21;
/// Smallest mean difference between day and night, 1/min: half of the least that sleep brings about.
const SMALLEST_DIFFERENCE: f64 = 3.0;
/// Fewest days with both.
const FEWEST_DAYS: usize = 4;
/// Share of the hours' steps that must be recorded.
const RECORDED: f64 = 0.5;
/// Length of a bin of the comparison with steps, steps of the record: 15 min.
const BIN: usize = 3;
/// Largest offset of the heart rate against the step count, bins: 12 h.
const LARGEST: isize = (12 * STEPS_PER_HOUR / BIN) as isize;
/// Smallest offset that is reported, bins: 45 min. Smoothing moves a peak by less.
const SMALLEST_OFFSET: usize = 3;
/// Smallest correlation at the offset, and the smallest gain over none.
const CORRELATION: f64 = 0.3;
const GAIN: f64 = 0.15;

pub(super) fn finding(person: &Person) -> Option<Finding> {
    let differences = day_minus_night(person);
    let (text, estimate, unit) = if differences.len() >= FEWEST_DAYS
        && let Some(mean) = mean_with_interval(&differences)
        && mean.2 < SMALLEST_DIFFERENCE
    {
        let text = format!(
            "heart rate is {:.1}/min higher by day (10 to 21 h) than by night (0 to 6 h), where sleep \
             makes 10 or more: its times are not this record's; align it or leave it out",
            mean.0
        );
        (text, mean, "1/min")
    } else {
        let minutes = behind_steps(person)?;
        let text = format!(
            "heart rate follows the step count by {minutes:+.0} min: the two lie on different clocks; move \
             the heart rate by {:+.0} min or leave it out",
            -minutes
        );
        let half_bin = 2.5 * BIN as f64;
        (text, (minutes, minutes - half_bin, minutes + half_bin), "min")
    };
    let ignored = Consequence::IgnoreChannel(Channel::HeartRate);
    Some(Finding::new("heart_rate_alignment", person, ignored, text).with_estimate(estimate, unit))
}

/// Mean heart rate of each day's day hours minus that of its night hours, 1/min.
fn day_minus_night(person: &Person) -> Vec<f64> {
    let record = &person.record;
    let days = record.day_index(record.len().saturating_sub(1)) + 1;
    let mut sums = vec![[(0.0, 0usize); 2]; days];
    for (k, rate) in record.heart_rate().iter().enumerate() {
        let hour = record.hour(k);
        let part = [NIGHT, DAY].iter().position(|hours| hours.contains(&hour));
        if let (Some(part), Some(rate)) = (part, rate) {
            let sum = &mut sums[record.day_index(k)][part];
            *sum = (sum.0 + rate, sum.1 + 1);
        }
    }
    let enough = |count: usize, hours: &std::ops::Range<u8>| {
        count as f64 >= RECORDED * (hours.len() * STEPS_PER_HOUR) as f64
    };
    sums.iter()
        .filter(|[night, day]| enough(night.1, &NIGHT) && enough(day.1, &DAY))
        .map(|[night, day]| day.0 / day.1 as f64 - night.0 / night.1 as f64)
        .collect()
}

/// Offset of the heart rate behind the step count, min, where there clearly is one.
fn behind_steps(person: &Person) -> Option<f64> {
    let record = &person.record;
    let binned = |values: &[Option<f64>]| -> Vec<Option<f64>> {
        let sums = values.chunks_exact(BIN).map(|bin| bin.iter().copied().sum::<Option<f64>>());
        sums.map(|sum| Some(sum? / BIN as f64)).collect()
    };
    let (heart, steps) = (binned(record.heart_rate()), binned(record.steps()));
    let walked: Vec<Option<f64>> = steps.iter().map(|s| s.map(|s| s.max(0.0).sqrt())).collect();
    let both = heart.iter().zip(&walked).filter(|(h, w)| h.is_some() && w.is_some()).count();
    if both < FEWEST_DAYS * STEPS_PER_DAY / BIN / 2 {
        return None;
    }
    let at = |offset: isize| {
        let mut sums = [0.0; 6];
        for (k, walked) in walked.iter().enumerate() {
            let heart = k.checked_add_signed(offset).and_then(|k| *heart.get(k)?);
            if let (Some(x), Some(y)) = (walked, heart) {
                for (sum, value) in sums.iter_mut().zip([1.0, *x, y, x * x, y * y, x * y]) {
                    *sum += value;
                }
            }
        }
        let [n, x, y, xx, yy, xy] = sums;
        let spread = (xx - x * x / n) * (yy - y * y / n);
        if n > 0.0 && spread > 0.0 { (xy - x * y / n) / spread.sqrt() } else { 0.0 }
    };
    let none = at(0);
    let (offset, best) = (-LARGEST..=LARGEST)
        .map(|offset| (offset, at(offset)))
        .fold((0, none), |best, next| if next.1 > best.1 { next } else { best });
    let clear = best >= CORRELATION && best - none >= GAIN;
    (clear && offset.unsigned_abs() >= SMALLEST_OFFSET)
        .then_some(5.0 * (offset * BIN as isize) as f64)
}
