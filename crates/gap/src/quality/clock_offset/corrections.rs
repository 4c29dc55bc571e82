//! When glucose turned: the insulin clock of people who correct by hand.
//!
//! A bolus without a meal is given because glucose has risen, and makes it fall. Around such boluses
//! glucose has its peak some [`TURN`] steps after the bolus, in whatever person. If the insulin clock
//! is off, the peak lies elsewhere. The height of glucose over the mean of its values an hour and a
//! half before and after, averaged over corrections, is largest at the turn.

use physiology::STEPS_PER_DAY;

use super::{Minutes95, redrawn, total};

/// Largest offset that is searched, steps: 3 h.
const SEARCHED: i32 = 36;
/// Where glucose turns after a correction, steps: 20 min in the records that were looked at, time
/// for insulin to begin to act.
const TURN: i32 = 4;
/// Bins of the table: turns from -([`SEARCHED`] + 8) to [`SEARCHED`] + 8 steps.
const REACH: i32 = SEARCHED + 2 * TURN;
const BINS: usize = 2 * REACH as usize + 1;
/// Half-width of the tent, steps: 90 min.
const HALF_WIDTH: i32 = 18;
/// Largest height that counts, mg/dL: one wild excursion must not decide.
const CAP: f64 = 60.0;
/// Smallest bolus that is a person's correction, U: controllers give less.
pub(super) const SMALLEST_BOLUS: f64 = 0.3;
/// Steps around a bolus in which no meal is logged: half an hour.
const ALONE: i32 = 6;
/// Fewest corrections for a comparison, and for an estimate.
const FEWEST: usize = 5;
const FEWEST_FOR_ESTIMATE: usize = 10;
/// Bootstrap replicates over days.
const REPLICATES: usize = 200;
/// Scatter of the turn between people, min (standard deviation over clean records).
const TURN_SD: f64 = 15.0;

/// Heights of glucose around corrections, by day and by bin of the assumed turn.
pub(super) struct Corrections {
    days: Vec<[f64; BINS]>,
    count: usize,
}

impl Corrections {
    /// Collects the corrections of a record: boluses without a meal, when meals lie `apart` steps
    /// before boluses in the record. `None` where there are too few.
    pub(super) fn of(
        carbs: &[f64],
        bolus: &[f64],
        cgm: &[Option<f64>],
        apart: i32,
    ) -> Option<Self> {
        let n = cgm.len();
        let inside = |k: i64| usize::try_from(k).ok().filter(|k| *k < n);
        let smooth: Vec<Option<f64>> = (0..n)
            .map(|k| {
                let near = &cgm[k.saturating_sub(1)..(k + 2).min(n)];
                let (sum, count) = near
                    .iter()
                    .flatten()
                    .fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
                (count > 0.0).then(|| sum / count)
            })
            .collect();
        let at = |k: i64| inside(k).and_then(|k| smooth[k]);
        let mut days = vec![[0.0; BINS]; n.div_ceil(STEPS_PER_DAY)];
        let mut count = 0;
        for (k, _) in bolus.iter().enumerate().filter(|(_, dose)| **dose > SMALLEST_BOLUS) {
            let step = k as i64;
            let mut near = (-ALONE..=ALONE).map(|d| step - i64::from(apart + d));
            if near.any(|k| inside(k).is_some_and(|k| carbs[k] > 0.0)) {
                continue;
            }
            count += 1;
            let day = &mut days[k / STEPS_PER_DAY];
            for (index, sum) in (-REACH..=REACH).zip(day.iter_mut()) {
                let turn = step + i64::from(index);
                let width = i64::from(HALF_WIDTH);
                if let (Some(before), Some(peak), Some(after)) =
                    (at(turn - width), at(turn), at(turn + width))
                {
                    *sum += (peak - 0.5 * (before + after)).clamp(-CAP, CAP);
                }
            }
        }
        (count >= FEWEST).then_some(Self { days, count })
    }

    /// By how many standard errors over days the corrections prefer one offset of the insulin clock,
    /// steps, to another.
    pub(super) fn preference(&self, first: i32, second: i32) -> f64 {
        let index = |offset: i32| usize::try_from((TURN - offset).clamp(-REACH, REACH) + REACH);
        let (Ok(first), Ok(second)) = (index(first), index(second)) else { return 0.0 };
        let (sum, squares) = self.days.iter().fold((0.0, 0.0), |(sum, squares), day| {
            let difference = day[first] - day[second];
            (sum + difference, squares + difference * difference)
        });
        if squares > 0.0 { sum / f64::sqrt(squares) } else { 0.0 }
    }

    /// The insulin clock's offset, with a 95 % interval over days and over people's turns; `None`
    /// with fewer than ten corrections.
    pub(super) fn delay(&self) -> Option<Minutes95> {
        if self.count < FEWEST_FOR_ESTIMATE {
            return None;
        }
        let value = delay(&total(&self.days));
        let drawn = redrawn(&self.days, REPLICATES, |sample| Some(delay(&total(sample))));
        let at = |share: f64| drawn[(share * (REPLICATES - 1) as f64).round() as usize];
        let (below, above) = ((value - at(0.025)).max(0.0), (at(0.975) - value).max(0.0));
        let people = 2.0 * TURN_SD;
        Some(Minutes95 {
            value,
            lower: value - below.hypot(people),
            upper: value + above.hypot(people),
        })
    }
}

/// The offset at which the turn is sharpest, min.
fn delay(table: &[f64; BINS]) -> f64 {
    let weights = [1.0, 2.0, 3.0, 2.0, 1.0];
    let (index, _) = table
        .windows(weights.len())
        .map(|near| near.iter().zip(weights).map(|(value, weight)| value * weight).sum::<f64>())
        .enumerate()
        .fold(
            (0, f64::NEG_INFINITY),
            |best, (index, height)| {
                if height > best.1 { (index + 2, height) } else { best }
            },
        );
    5.0 * (f64::from(TURN + REACH) - index as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fortnight in which glucose rises and falls in tents, a bolus 20 min before each peak but
    /// recorded `steps` late, and a meal with a bolus in every valley.
    fn tents(steps: usize) -> (Vec<f64>, Vec<f64>, Vec<Option<f64>>) {
        let n = 14 * STEPS_PER_DAY;
        let cgm = (0..n).map(|k| Some(220.0 - 2.0 * (k % 96).abs_diff(48) as f64)).collect();
        let (mut carbs, mut bolus) = (vec![0.0; n], vec![0.0; n]);
        for start in (0..n - 96).step_by(96) {
            bolus[start + 44 + steps] = 2.0;
            carbs[start + 4] = 40.0;
            bolus[start + 4 + steps] = 4.0;
        }
        (carbs, bolus, cgm)
    }

    #[test]
    fn the_turn_tells_the_offset_and_meals_are_left_aside() {
        for steps in [0, 6, 12] {
            let (carbs, bolus, cgm) = tents(steps);
            let apart = i32::try_from(steps).expect("small");
            let found = Corrections::of(&carbs, &bolus, &cgm, apart).expect("corrections");
            assert_eq!(found.count, 41);
            let delay = found.delay().expect("many");
            assert_eq!(delay.value, 5.0 * steps as f64);
            assert!(delay.lower < delay.value - 25.0 && delay.upper > delay.value + 25.0);
            assert!(found.preference(apart, apart + 12) > 3.0);
            assert!(found.preference(apart - 12, apart) < -3.0);
        }
    }

    #[test]
    fn few_corrections_tell_nothing() {
        let (carbs, bolus, cgm) = tents(0);
        let short = 300;
        let cgm = &cgm[..short];
        assert!(Corrections::of(&carbs[..short], &bolus[..short], cgm, 0).is_none());
    }
}
