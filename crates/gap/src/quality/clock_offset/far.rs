//! Clocks that are many hours off: a log that confuses morning and evening.
//!
//! Within three hours the distance of boluses from meals is searched by [`dose_distance`](super::dose_distance).
//! Further away people's habits answer: lunch lies five hours after every breakfast's bolus. Habit repeats from day to
//! day, a clock's error ties a bolus to the meal of one day. So doses at each distance are compared with doses at
//! the same hours of the day, some days before and after.

use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};
use statrs::distribution::{ContinuousCDF as _, Normal};

use super::dose_distance::{HALF_WIDTH, SEARCHED, pairs, sized};
use super::{DoseSteps, Minutes95, under_triangle};

/// Largest distance, steps: 12 h; a larger one is a smaller one of the other sign on another day.
const FARTHEST: usize = STEPS_PER_DAY / 2;
/// Clocks are wrong by half hours, steps: by time zones, or by morning and evening. The triangle of 15 min to each side leaves
/// room for habit.
const STEP_OF_CLOCKS: usize = STEPS_PER_HOUR / 2;
/// Days before and after that show habit.
const MOST_DAYS: usize = 7;
/// Fewest of them on each side.
const FEWEST_DAYS: usize = 3;
/// Chance that a sound record shows such a distance, over all that are searched.
const FALSE_ALARM: f64 = 0.001;
/// How many times what lies within the near distances, beyond habit, the far one must have: where a record ties boluses to
/// meals nearby, its clocks agree.
const PREFERENCE: f64 = 3.0;

/// The far distance at which boluses follow meals of the same day, if there is one.
pub(super) fn distance(carbs: &[f64], bolus: &[f64]) -> Option<Minutes95> {
    let whole = carbs.len() / STEPS_PER_DAY;
    let days = MOST_DAYS.min(whole / 2);
    if days < FEWEST_DAYS {
        return None;
    }
    let reach = days * STEPS_PER_DAY + FARTHEST + HALF_WIDTH;
    let mut table = vec![0.0; 2 * reach + 1];
    pairs(carbs, bolus, reach, |_, place, sizes| table[place] += sizes)?;
    let beyond_habit = |distance: i64| beyond_habit(&table, distance, days as i64, whole);
    let (far, near) = (FARTHEST as i64, SEARCHED as i64);
    let searched: Vec<(i64, (f64, f64))> = (-far..=far)
        .step_by(STEP_OF_CLOCKS)
        .filter(|distance| distance.abs() > near)
        .map(|distance| (distance, beyond_habit(distance)))
        .collect();
    let (best, (weight, z)) = searched.iter().max_by(|(_, a), (_, b)| a.1.total_cmp(&b.1))?;
    let nearby = (-near..=near).map(|distance| beyond_habit(distance).0).fold(0.0, f64::max);
    let least = Normal::standard().inverse_cdf(1.0 - FALSE_ALARM / searched.len() as f64);
    let value = 5.0 * *best as f64;
    let found = Minutes95 { value, lower: value, upper: value }.widened(5.0 * HALF_WIDTH as f64);
    (*z > least && *weight > PREFERENCE * nearby).then_some(found)
}

/// What a distance has beyond habit, the mean of other days, within so many `days`; and the same in standard deviations
/// of a count about that mean. The variance of a count is its mean; products are at most 1.
///
/// `table` has the products of capped sizes of every meal and every bolus by their distance. `whole` is the number of
/// days of the record: fewer pairs of days lie further apart.
fn beyond_habit(table: &[f64], distance: i64, days: i64, whole: usize) -> (f64, f64) {
    let at = |distance: i64| {
        let place = (table.len() / 2) as i64 + distance;
        under_triangle(table, place as usize, HALF_WIDTH) / (HALF_WIDTH + 1) as f64
    };
    let other_days = (-days..=days).filter(|day| *day != 0).map(|day| {
        let pairs = 1.0 - day.abs() as f64 / whole as f64;
        at(distance + day * STEPS_PER_DAY as i64) / pairs
    });
    let mut other_days: Vec<f64> = other_days.collect();
    // A log that confuses morning and evening moves half of its meals one way and half the other, which is the
    // same distance on another day.
    other_days.sort_by(f64::total_cmp);
    other_days.pop();
    let count = other_days.len() as f64;
    let habit = other_days.iter().sum::<f64>() / count;
    let weight = at(distance) - habit;
    (weight, weight / ((habit + 1.0) * (1.0 + 1.0 / count)).sqrt())
}

/// By how many standard errors glucose rises more after meals than after boluses as they are logged: people dose for what
/// they eat, so that glucose rises after whichever of the two has the sensor's clock. `None` without enough readings.
pub(super) fn rises_after_meals(doses: &DoseSteps<'_>) -> Option<f64> {
    /// Time from a meal to its peak, steps: 90 min.
    const TO_PEAK: usize = 18;
    let cgm = doses.person.record.cgm();
    // The mean rise after large doses, and its variance.
    let rise = |amounts: &[f64]| -> Option<(f64, f64)> {
        let large = sized(amounts, |sorted| sorted[sorted.len() / 2])?;
        let rises: Vec<f64> = large
            .into_iter()
            .filter(|(_, size)| *size >= 1.0)
            .filter_map(|(k, _)| Some((*cgm.get(k + TO_PEAK)?)? - (*cgm.get(k)?)?))
            .collect();
        if rises.len() < 5 {
            return None;
        }
        let count = rises.len() as f64;
        let mean = rises.iter().sum::<f64>() / count;
        let spread = rises.iter().map(|rise| (rise - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Some((mean, spread / count))
    };
    let ((meals, of_meals), (boluses, of_boluses)) = (rise(&doses.carbs)?, rise(&doses.bolus)?);
    Some((meals - boluses) / f64::max(of_meals + of_boluses, f64::MIN_POSITIVE).sqrt())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Four weeks of three meals a day at about the same hours, each with its bolus, which is recorded `late` steps
    /// after it.
    fn doses(late: i64) -> (Vec<f64>, Vec<f64>) {
        let days = 28;
        let mut carbs = vec![0.0; days * STEPS_PER_DAY];
        let mut bolus = carbs.clone();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for day in 0..days {
            for hour in [7, 13, 19] {
                let at = day * STEPS_PER_DAY + 12 * hour + rng.random_range(0..18);
                carbs[at] = 40.0;
                if let Ok(recorded) = usize::try_from(at as i64 + late)
                    && let Some(bolus) = bolus.get_mut(recorded)
                {
                    *bolus = 4.0;
                }
            }
        }
        (carbs, bolus)
    }

    #[test]
    fn half_a_day_and_half_a_night_are_found_and_habit_is_not() {
        for hours in [-12, -9, 5, 12] {
            let (carbs, bolus) = doses(12 * hours);
            let found = distance(&carbs, &bolus).expect("tied at that distance");
            assert!((found.value - 60.0 * hours as f64).abs() <= 5.0, "{hours}: {found:?}");
        }
        for steps in [0, 6, -24] {
            let (carbs, bolus) = doses(steps);
            assert_eq!(distance(&carbs, &bolus), None, "{steps}");
        }
    }
}
