//! The change of insulin action from day to day that keeps a replayed body in range.

use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::toward::SLOPE;
use crate::effects::Condition;

/// Hour of the day about which one day's restoring change passes into the next's, steps.
const CHANGE: usize = 3 * STEPS_PER_HOUR;
/// Largest restoring change (log), and the largest plausible spread between days.
const LARGEST_CHANGE: f64 = 0.9;
pub(super) const LARGEST_SPREAD: f64 = 0.45;
/// Range in which a day's mean and its 5th and 95th percentiles shall lie, mg/dL.
const DAY_MEANS: (f64, f64) = (95.0, 230.0);
const DAY_EXTREMES: (f64, f64) = (55.0, 340.0);
/// Largest change of a day's action in one round of the search (log).
const LARGEST_STEP: f64 = 0.25;

/// The log factor on insulin action of a step, passing from day to day within two hours about 3:00.
fn change_at(restoring: &[f64], step: usize) -> f64 {
    let of = |day: usize| restoring.get(day).or(restoring.last()).copied().unwrap_or(0.0);
    let day = step / STEPS_PER_DAY;
    let into = (step % STEPS_PER_DAY) as f64 - CHANGE as f64;
    let share = (into / (2.0 * STEPS_PER_HOUR as f64) + 0.5).clamp(0.0, 1.0);
    let before = if day == 0 { of(0) } else { of(day - 1) };
    before + share * (of(day) - before)
}

/// Lets the restoring change act on the conditions of a record that starts at `offset`.
pub(super) fn restore(conditions: &mut [Condition], offset: usize, restoring: &[f64]) {
    for (step, condition) in conditions.iter_mut().enumerate() {
        let factor = change_at(restoring, step + offset).exp();
        condition.action *= factor;
        condition.liver_action *= factor;
    }
}

/// Moves the action of the days that leave the range in the course `glucose` of a record that
/// starts at `offset`, mg/dL. Lows are corrected before highs.
pub(super) fn mend(restoring: &mut [f64], glucose: &[f64], offset: usize) {
    for (day, change) in restoring.iter_mut().enumerate() {
        let from = (day * STEPS_PER_DAY + CHANGE).saturating_sub(offset);
        let to = ((day + 1) * STEPS_PER_DAY + CHANGE).saturating_sub(offset);
        let Some(within) = glucose.get(from..to.min(glucose.len())) else { continue };
        if within.len() < STEPS_PER_DAY / 4 {
            continue;
        }
        let step = excess(within) / SLOPE;
        *change = (*change + step.clamp(-LARGEST_STEP, LARGEST_STEP))
            .clamp(-LARGEST_CHANGE, LARGEST_CHANGE);
    }
}

/// How far a day lies above the range, mg/dL; negative below it, 0 within.
fn excess(day: &[f64]) -> f64 {
    let mut sorted = day.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted[(share * (sorted.len() - 1) as f64) as usize];
    let beyond =
        |value: f64, (low, high): (f64, f64)| (value - high).max(0.0) + (value - low).min(0.0);
    let low = beyond(at(0.05), (DAY_EXTREMES.0, f64::INFINITY));
    let high = 0.5 * beyond(at(0.95), (f64::NEG_INFINITY, DAY_EXTREMES.1));
    beyond(mean(day), DAY_MEANS) + if low < 0.0 { low } else { high }
}

/// Mean of values clamped to a sensor's range, so that one extreme day does not dominate it.
pub(super) fn mean(glucose: &[f64]) -> f64 {
    glucose.iter().map(|g| g.clamp(40.0, 400.0)).sum::<f64>() / glucose.len() as f64
}

/// Standard deviation of the change between days (log).
pub(super) fn spread(restoring: &[f64]) -> f64 {
    let days = restoring.len() as f64;
    let middle = restoring.iter().sum::<f64>() / days;
    (restoring.iter().map(|change| (change - middle).powi(2)).sum::<f64>() / days).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_within_the_range_are_left_alone() {
        let fine: Vec<f64> = (0..288)
            .map(|k| 150.0 + 60.0 * (std::f64::consts::TAU * k as f64 / 144.0).sin())
            .collect();
        assert_eq!(excess(&fine), 0.0);
        let higher: Vec<f64> = fine.iter().map(|g| g + 100.0).collect();
        let lower: Vec<f64> = fine.iter().map(|g| g - 70.0).collect();
        assert!((excess(&higher) - 20.0).abs() < 2.0); // a mean of 250: 20 above its limit
        assert!(excess(&lower) < -40.0); // lows near 20, a mean of 80
        let days: Vec<f64> = [&fine[..], &higher, &lower].concat();
        let mut restoring = vec![0.0; 3];
        mend(&mut restoring, &days, CHANGE); // the record starts as a day of the change does
        assert_eq!(restoring[0], 0.0);
        assert!(restoring[1] > 0.05 && restoring[2] < -0.2, "{restoring:?}");
        assert!(spread(&restoring) > 0.1);
    }

    #[test]
    fn the_change_passes_smoothly_from_day_to_day() {
        let restoring = [0.2, -0.4, 0.1];
        assert_eq!(change_at(&restoring, 0), 0.2);
        assert_eq!(change_at(&restoring, STEPS_PER_DAY), 0.2);
        assert!((change_at(&restoring, STEPS_PER_DAY + CHANGE) + 0.1).abs() < 1e-12); // half-way
        assert!((change_at(&restoring, STEPS_PER_DAY + 2 * CHANGE) + 0.4).abs() < 1e-12); // rounding
        assert_eq!(change_at(&restoring, 5 * STEPS_PER_DAY), 0.1);
        assert_eq!(change_at(&[], 700), 0.0);
        let steps = (1..3 * STEPS_PER_DAY)
            .map(|k| (change_at(&restoring, k) - change_at(&restoring, k - 1)).abs());
        assert!(steps.fold(0.0, f64::max) < 0.6 / 24.0 + 1e-12); // two hours for at most 0.6
    }
}
