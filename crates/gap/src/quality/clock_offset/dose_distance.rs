//! How far boluses lie from the meals that they were given for.
//!
//! People log a meal and its bolus at one moment, so the distances between the two pile up at one
//! value. Every pair of a meal and a bolus within four hours adds the product of their sizes at
//! their distance; the position of the peak is the offset between the two clocks. Sizes are capped, so
//! that a few large doses do not decide.

use physiology::STEPS_PER_DAY;

use super::{Minutes95, highest, total, under_triangle, z_over_days};

/// Largest distance between a bolus and a meal that is counted, steps: 4 h.
const REACH: usize = 48;
/// Bins of the table: distances from -[`REACH`] to [`REACH`].
const BINS: usize = 2 * REACH + 1;
/// Largest distance that is searched, steps: 3 h.
pub(super) const SEARCHED: usize = 36;
/// Half-width of the smoothing triangle and of the centroid, steps: 15 min.
pub(super) const HALF_WIDTH: usize = 3;
/// Fewest meals and fewest boluses.
const FEWEST_DOSES: usize = 10;
/// Bootstrap replicates over days.
const REPLICATES: usize = 200;
/// A recorded dose lies anywhere in its step, so a distance is known to one step at best, min.
const GRID: f64 = 5.0;
/// Fewest days on each side of a change.
const FEWEST_DAYS: usize = 4;
/// Smallest change that is looked for, steps: 20 min.
const SMALLEST_CHANGE: usize = 4;
/// How many times higher than at the other side's distance each side of a change must be.
const PREFERENCE: f64 = 3.0;
/// Standard errors, over days, by which each side of a change must prefer its own distance.
const PREFERENCE_Z: f64 = 1.9;

/// Weighted counts of the distances from the meals of one day of the record to boluses.
pub(super) type DayTable = [f64; BINS];

/// Counts the pairs of a record's channels by day; `None` with fewer than [`FEWEST_DOSES`] of either.
pub(super) fn count(carbs: &[f64], bolus: &[f64]) -> Option<Vec<DayTable>> {
    let mut days = vec![[0.0; BINS]; carbs.len().div_ceil(STEPS_PER_DAY)];
    pairs(carbs, bolus, REACH, |meal, place, sizes| days[meal / STEPS_PER_DAY][place] += sizes)?;
    Some(days)
}

/// The distance at the peak over some days, bolus after meal, with a 95 % interval over days,
/// widened by the grid; `None` if nothing was counted.
pub(super) fn peak(days: &[DayTable]) -> Option<Minutes95> {
    let found = Minutes95::bootstrapped(days, REPLICATES, |drawn| centroid(&total(drawn)))?;
    Some(found.widened(GRID))
}

/// The first day of another distance than before, if the record has one.
///
/// Both sides must have at least [`FEWEST_DAYS`] days and a peak of their own that stands out
/// against the other side's distance.
pub(super) fn change(days: &[DayTable]) -> Option<usize> {
    let parted = FEWEST_DAYS..(days.len() + 1).saturating_sub(FEWEST_DAYS);
    let scored = parted.filter_map(|day| {
        let (before, after) = days.split_at(day);
        let (first, second) = (peak_place(&total(before))?, peak_place(&total(after))?);
        if first.abs_diff(second) < SMALLEST_CHANGE {
            return None;
        }
        Some((preference(before, first, second)? + preference(after, second, first)?, day))
    });
    let clearest = scored.reduce(|best, next| if next.0 > best.0 { next } else { best });
    clearest.map(|(_, day)| day)
}

/// Steps and capped sizes of the doses above zero.
pub(super) fn sized(doses: &[f64], cap: impl Fn(&[f64]) -> f64) -> Option<Vec<(usize, f64)>> {
    let given = || doses.iter().copied().enumerate().filter(|(_, dose)| *dose > 0.0);
    let mut sorted: Vec<f64> = given().map(|(_, dose)| dose).collect();
    if sorted.len() < FEWEST_DOSES {
        return None;
    }
    sorted.sort_by(f64::total_cmp);
    let cap = cap(&sorted);
    Some(given().map(|(step, dose)| (step, (dose / cap).min(1.0))).collect())
}

/// Every meal and every bolus within `reach` steps of it: `count` gets the step of the meal, the distance of the bolus
/// from it plus `reach`, and the product of their capped sizes. `None` with fewer than [`FEWEST_DOSES`] of either.
pub(super) fn pairs(
    carbs: &[f64],
    bolus: &[f64],
    reach: usize,
    mut count: impl FnMut(usize, usize, f64),
) -> Option<()> {
    // A meal counts in full from twice the median on, a bolus from the upper quartile on.
    let meals = sized(carbs, |sorted| 2.0 * sorted[sorted.len() / 2])?;
    let boluses = sized(bolus, |sorted| sorted[sorted.len() * 3 / 4])?;
    for (meal, size) in meals {
        let first = boluses.partition_point(|(bolus, _)| bolus + reach < meal);
        let near = boluses[first..].iter().take_while(|(bolus, _)| *bolus <= meal + reach);
        near.for_each(|(bolus, units)| count(meal, bolus + reach - meal, size * units));
    }
    Some(())
}

/// Place of the highest smoothed value within the searched distances; `None` if all are zero.
fn peak_place(table: &DayTable) -> Option<usize> {
    let searched = REACH - SEARCHED..=REACH + SEARCHED;
    let (place, height) = highest(searched, |place| under_triangle(table, place, HALF_WIDTH));
    (height > 0.0).then_some(place)
}

/// Centroid around the peak, min.
fn centroid(table: &DayTable) -> Option<f64> {
    let place = peak_place(table)?;
    let around = place - HALF_WIDTH..=place + HALF_WIDTH;
    let weight: f64 = table[around.clone()].iter().sum();
    let moment: f64 = around.map(|at| table[at] * (at as f64 - REACH as f64)).sum();
    Some(5.0 * moment / weight)
}

/// By how many standard errors the days prefer one distance to another; `None` if not clearly.
fn preference(days: &[DayTable], own: usize, other: usize) -> Option<f64> {
    let at = |place: usize| days.iter().map(move |day| under_triangle(day, place, HALF_WIDTH));
    let z = z_over_days(at(own).zip(at(other)).map(|(own, other)| own - other));
    let clear = at(own).sum::<f64>() >= PREFERENCE * at(other).sum::<f64>() && z >= PREFERENCE_Z;
    clear.then_some(z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three meals a day for ten days, each with a bolus `distance` steps later from day `from` on
    /// and at once before, and a correction every evening.
    fn doses(from: usize, distance: usize) -> (Vec<f64>, Vec<f64>) {
        let mut carbs = vec![0.0; 10 * STEPS_PER_DAY];
        let mut bolus = carbs.clone();
        for day in 0..10 {
            for (index, hour) in [7, 13, 19].into_iter().enumerate() {
                let at = day * STEPS_PER_DAY + 12 * hour + (day * 7 + index * 5) % 11;
                carbs[at] = 40.0;
                bolus[at + if day >= from { distance } else { 0 }] = 4.0;
            }
            bolus[day * STEPS_PER_DAY + 270 + day % 3] = 1.0;
        }
        (carbs, bolus)
    }

    #[test]
    fn the_peak_lies_at_the_planted_distance() {
        for distance in [0, 6, 24] {
            let (carbs, bolus) = doses(0, distance);
            let table = count(&carbs, &bolus).expect("30 meals");
            let found = peak(&table).expect("a peak");
            let planted = 5.0 * distance as f64;
            // All pairs lie at one distance: the interval is the grid alone.
            assert_eq!(found.value, planted);
            assert_eq!((found.lower, found.upper), (planted - 5.0, planted + 5.0));
            assert_eq!(change(&table), None);
        }
    }

    #[test]
    fn a_change_of_distance_is_dated() {
        let (carbs, bolus) = doses(6, 12);
        let table = count(&carbs, &bolus).expect("30 meals");
        assert_eq!(change(&table), Some(6));
        assert_eq!(peak(&table[..6]).map(|m| m.value), Some(0.0));
        assert_eq!(peak(&table[6..]).map(|m| m.value), Some(60.0));
    }

    #[test]
    fn few_doses_give_no_table() {
        let (carbs, bolus) = doses(0, 0);
        assert!(count(&carbs[..2 * STEPS_PER_DAY], &bolus).is_none());
        assert!(count(&carbs, &vec![0.0; bolus.len()]).is_none());
    }
}
