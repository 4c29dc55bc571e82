//! How far boluses lie from the meals that they were given for.
//!
//! People log a meal and its bolus at one moment, so the distances between the two pile up at one
//! value. Every pair of a meal and a bolus within four hours adds the product of their sizes at
//! their distance; the position of the peak is the offset between the two clocks. Sizes are capped, so
//! that a few large doses do not decide.

use std::ops::Range;

use physiology::STEPS_PER_DAY;

use super::{Minutes95, redrawn, total};

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

/// Weighted counts of the distances from meals to boluses, one table a day of the record.
#[derive(Debug, Clone)]
pub(super) struct DoseDistances {
    days: Vec<[f64; BINS]>,
}

impl DoseDistances {
    /// Counts the pairs of a record's channels; `None` with fewer than [`FEWEST_DOSES`] of either.
    pub(super) fn count(carbs: &[f64], bolus: &[f64]) -> Option<Self> {
        let mut days = vec![[0.0; BINS]; carbs.len().div_ceil(STEPS_PER_DAY)];
        pairs(carbs, bolus, REACH, |meal, index, sizes| {
            days[meal / STEPS_PER_DAY][index] += sizes;
        })?;
        Some(Self { days })
    }

    /// Number of days.
    pub(super) fn days(&self) -> usize {
        self.days.len()
    }

    /// The distance at the peak over some days, bolus after meal, with a 95 % interval over days,
    /// widened by the grid; `None` if nothing was counted.
    pub(super) fn peak(&self, days: Range<usize>) -> Option<Minutes95> {
        let days = &self.days[days];
        let value = centroid(&total(days))?;
        let drawn = redrawn(days, REPLICATES, |sample| centroid(&total(sample)));
        let last = drawn.len().checked_sub(1)?;
        let at = |share: f64| drawn[(share * last as f64).round() as usize];
        let (lower, upper) = (at(0.025).min(value) - GRID, at(0.975).max(value) + GRID);
        Some(Minutes95 { value, lower, upper })
    }

    /// The first day of another distance than before, if the record has one.
    ///
    /// Both sides must have at least [`FEWEST_DAYS`] days and a peak of their own that stands out
    /// against the other side's distance.
    pub(super) fn change(&self) -> Option<usize> {
        let mut best: Option<(f64, usize)> = None;
        for day in FEWEST_DAYS..(self.days.len() + 1).saturating_sub(FEWEST_DAYS) {
            let (before, after) = self.days.split_at(day);
            let peaks = (peak_index(&total(before)), peak_index(&total(after)));
            let (Some(first), Some(second)) = peaks else { continue };
            if first.abs_diff(second) < SMALLEST_CHANGE {
                continue;
            }
            let z = preference(before, first, second).zip(preference(after, second, first));
            if let Some((before, after)) = z
                && best.is_none_or(|(most, _)| before + after > most)
            {
                best = Some((before + after, day));
            }
        }
        best.map(|(_, day)| day)
    }
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
    let mut first = 0;
    for (meal, size) in meals {
        while boluses.get(first).is_some_and(|(bolus, _)| bolus + reach < meal) {
            first += 1;
        }
        for (bolus, units) in &boluses[first..] {
            let place = bolus + reach - meal;
            if place > 2 * reach {
                break;
            }
            count(meal, place, size * units);
        }
    }
    Some(())
}

/// The table under a triangle of [`HALF_WIDTH`] steps on each side of a bin.
fn smoothed(table: &[f64; BINS], index: usize) -> f64 {
    let weight = |at: usize| (HALF_WIDTH + 1 - at.abs_diff(index)) as f64;
    let around = index - HALF_WIDTH..=index + HALF_WIDTH;
    around.map(|at| table[at] * weight(at)).sum::<f64>() / ((HALF_WIDTH + 1).pow(2)) as f64
}

/// Bin of the highest smoothed value within the searched distances; `None` if all are zero.
fn peak_index(table: &[f64; BINS]) -> Option<usize> {
    let searched = REACH - SEARCHED..=REACH + SEARCHED;
    let (index, height) = searched
        .map(|index| (index, smoothed(table, index)))
        .fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best });
    (height > 0.0).then_some(index)
}

/// Centroid around the peak, min.
fn centroid(table: &[f64; BINS]) -> Option<f64> {
    let index = peak_index(table)?;
    let around = index - HALF_WIDTH..=index + HALF_WIDTH;
    let (weight, moment) = around.fold((0.0, 0.0), |(weight, moment), at| {
        (weight + table[at], moment + table[at] * (at as f64 - REACH as f64))
    });
    Some(5.0 * moment / weight)
}

/// By how many standard errors the days prefer one distance to another; `None` if not clearly.
fn preference(days: &[[f64; BINS]], own: usize, other: usize) -> Option<f64> {
    let (mut at_own, mut at_other, mut sum, mut squares) = (0.0, 0.0, 0.0, 0.0);
    for day in days {
        let values = (smoothed(day, own), smoothed(day, other));
        at_own += values.0;
        at_other += values.1;
        sum += values.0 - values.1;
        squares += (values.0 - values.1).powi(2);
    }
    let z = sum / f64::max(squares, f64::MIN_POSITIVE).sqrt();
    (at_own >= PREFERENCE * at_other && z >= PREFERENCE_Z).then_some(z)
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
            let table = DoseDistances::count(&carbs, &bolus).expect("30 meals");
            let found = table.peak(0..table.days()).expect("a peak");
            let planted = 5.0 * distance as f64;
            // All pairs lie at one distance: the interval is the grid alone.
            assert_eq!(found.value, planted);
            assert_eq!((found.lower, found.upper), (planted - 5.0, planted + 5.0));
            assert_eq!(table.change(), None);
        }
    }

    #[test]
    fn a_change_of_distance_is_dated() {
        let (carbs, bolus) = doses(6, 12);
        let table = DoseDistances::count(&carbs, &bolus).expect("30 meals");
        assert_eq!(table.change(), Some(6));
        assert_eq!(table.peak(0..6).map(|m| m.value), Some(0.0));
        assert_eq!(table.peak(6..10).map(|m| m.value), Some(60.0));
    }

    #[test]
    fn few_doses_give_no_table() {
        let (carbs, bolus) = doses(0, 0);
        assert!(DoseDistances::count(&carbs[..2 * STEPS_PER_DAY], &bolus).is_none());
        assert!(DoseDistances::count(&carbs, &vec![0.0; bolus.len()]).is_none());
    }
}
