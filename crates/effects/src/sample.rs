//! A fortnight with everything in it, and the checks that every driver must pass.

use crate::course::Course;
use crate::effect::Effect;
use crate::modulation::{Field, Modulation};

/// Steps in a day.
pub(crate) const DAY: usize = 288;
/// Days of the fortnight.
const DAYS: usize = 14;
/// First step of a bout of exercise at 17 h.
pub(crate) const BOUT: usize = 4 * DAY + 204;
/// Its length in steps: 45 min at 50 beats over rest.
pub(crate) const BOUT_STEPS: usize = 9;
/// Days with a bout.
const BOUT_DAYS: [usize; 3] = [1, 4, 9];
/// A day whose night before was four hours short and broken.
pub(crate) const SHORT_NIGHT_BEFORE: usize = 6;
/// A step at which filtered glucose falls below 70 mg/dL with nothing logged nearby.
pub(crate) const LOW: usize = 8 * DAY + 187;

/// Fourteen days from midnight with meals, bouts, one short and broken night, lows in some afternoons, set changes every
/// third day at 15 h and a sensor changed on day 7 at noon.
pub(crate) fn fortnight() -> Course {
    let n = DAYS * DAY;
    let hour: Vec<f64> = (0..n).map(|k| (k % DAY) as f64 / 12.0).collect();
    let day: Vec<usize> = (0..n).map(|k| k / DAY).collect();
    let weekend = day.iter().map(|d| d % 7 >= 5).collect();
    let mut carbs = vec![0.0; n];
    let mut bolus = vec![0.0; n];
    let mut heart_rate = vec![Some(8.0); n];
    let mut walked = vec![Some(20.0); n];
    let mut asleep = vec![Some(0.0); n];
    let mut set_changed = vec![false; n];
    let mut glucose = vec![140.0; n];
    for d in 0..DAYS {
        let at = |h: f64| d * DAY + (h * 12.0) as usize;
        for (h, grams) in [(7.5, 35.0), (12.5, 45.0), (19.0, 75.0)] {
            let step = at(h) + d % 4;
            carbs[step] = grams;
            bolus[step] = grams / 10.0;
        }
        if BOUT_DAYS.contains(&d) {
            let start = d * DAY + BOUT % DAY;
            heart_rate[start..start + BOUT_STEPS].fill(Some(50.0));
            walked[start..start + BOUT_STEPS].fill(Some(600.0));
        }
        let (wakes, share) = if d == SHORT_NIGHT_BEFORE { (3.0, 0.8) } else { (7.0, 0.95) };
        asleep[at(0.0)..at(wakes)].fill(Some(share));
        asleep[at(23.0)..(d + 1) * DAY].fill(Some(0.95));
        if d % 3 == 0 {
            set_changed[at(15.0)] = true;
        }
        if d % 4 == 0 {
            for (k, value) in glucose[at(15.0)..at(16.5)].iter_mut().enumerate() {
                *value = 140.0 - 79.0 * (std::f64::consts::PI * k as f64 / 18.0).sin();
            }
        }
    }
    let sensor_age = (0..n).map(|k| ((k + DAY * 13 / 2) % (7 * DAY)) as f64 / DAY as f64).collect();
    Course {
        hour,
        day,
        weekend,
        carbs,
        bolus,
        heart_rate_over_rest: Some(heart_rate),
        walked: Some(walked),
        asleep: Some(asleep),
        set_changed: Some(set_changed),
        glucose,
        sensor_age: Some(sensor_age),
    }
}

/// What an effect does to every step, from nothing.
pub(crate) fn modulated(
    effect: &dyn Effect,
    variant: usize,
    amplitude: f64,
    course: &Course,
) -> Vec<Modulation> {
    let mut steps = vec![Modulation::NEUTRAL; course.len()];
    effect.modulate(variant, amplitude, course, &mut steps);
    steps
}

/// The same record up to a step and another one after it.
pub(crate) fn other_after(course: &Course, step: usize) -> Course {
    let mut other = course.clone();
    for k in step..course.len() {
        let odd = k % 7 == 0;
        other.carbs[k] = if odd { 30.0 } else { 1.0 };
        other.glucose[k] = 60.0 + (k % 200) as f64;
        if let Some(rates) = &mut other.heart_rate_over_rest {
            rates[k] = odd.then_some(90.0);
        }
        if let Some(steps) = &mut other.walked {
            steps[k] = odd.then_some(500.0);
        }
        if let Some(asleep) = &mut other.asleep {
            asleep[k] = Some(if odd { 1.0 } else { 0.3 });
        }
        if let Some(changed) = &mut other.set_changed {
            changed[k] = k % 301 == 0;
        }
        if let Some(ages) = &mut other.sensor_age {
            ages[k] = (k % 500) as f64 / 100.0;
        }
    }
    other
}

/// Steps at which the future is exchanged: a night, right after a breakfast and an onset of a low, after a dinner, in
/// a bout.
pub(crate) const CUTS: [usize; 5] = [3 * DAY + 17, 3 * DAY + 94, LOW + 1, 8 * DAY + 230, BOUT + 3];

/// A driver before centring must not change before a step when the record changes from there on.
pub(crate) fn looks_only_back(driver: impl Fn(&Course) -> Vec<Option<f64>>) {
    let course = fortnight();
    let here = driver(&course);
    for cut in CUTS {
        let there = driver(&other_after(&course, cut));
        assert_eq!(here[..cut], there[..cut], "before step {cut}");
        assert_ne!(here[cut..], there[cut..], "the exchange must reach the driver");
    }
}

/// The logarithm of a factor must add up to nothing within every clock slot.
pub(crate) fn zero_mean_by_slot(course: &Course, steps: &[Modulation], field: Field) {
    let mut sums = vec![0.0; DAY];
    for (hour, step) in course.hour.iter().zip(steps) {
        sums[(hour * 12.0).round() as usize % DAY] += step[field].ln();
    }
    // Fourteen terms below 1 each: rounding only.
    assert!(sums.iter().all(|sum: &f64| sum.abs() < 1e-12));
}
