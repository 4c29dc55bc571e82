//! When glucose turned: the insulin clock of people who correct by hand.
//!
//! A bolus without a meal is given because glucose has risen, and makes it fall. Around such boluses
//! glucose has its peak some [`TURN`] steps after the bolus, in whatever person. If the insulin clock
//! is off, the peak lies elsewhere. The height of glucose over the mean of its values an hour and a
//! half before and after, averaged over corrections, is largest at the turn.

use physiology::STEPS_PER_DAY;

use super::{DoseSteps, Minutes95, highest, total, under_triangle, z_over_days};

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
    pub(super) fn of(doses: &DoseSteps<'_>, apart: i32) -> Option<Self> {
        let cgm = doses.person.record.cgm();
        let inside = |k: i32| usize::try_from(k).ok().filter(|k| *k < cgm.len());
        // The mean of a reading and those beside it.
        let at = |k: i32| {
            let k = inside(k)?;
            let near = cgm[k.saturating_sub(1)..(k + 2).min(cgm.len())].iter().flatten();
            let count = near.clone().count();
            (count > 0).then(|| near.sum::<f64>() / count as f64)
        };
        let mut days = vec![[0.0; BINS]; cgm.len().div_ceil(STEPS_PER_DAY)];
        let mut count = 0;
        for (k, _) in doses.bolus.iter().enumerate().filter(|(_, dose)| **dose > SMALLEST_BOLUS) {
            let step = k as i32;
            let mut near = (-ALONE..=ALONE).map(|d| step - apart - d);
            if near.any(|k| inside(k).is_some_and(|k| doses.carbs[k] > 0.0)) {
                continue;
            }
            count += 1;
            for (turn, sum) in (step - REACH..).zip(&mut days[k / STEPS_PER_DAY]) {
                let tent = (at(turn - HALF_WIDTH), at(turn), at(turn + HALF_WIDTH));
                if let (Some(before), Some(peak), Some(after)) = tent {
                    *sum += (peak - 0.5 * (before + after)).clamp(-CAP, CAP);
                }
            }
        }
        (count >= FEWEST).then_some(Self { days, count })
    }

    /// By how many standard errors over days the corrections prefer one offset of the insulin clock,
    /// steps, to another.
    pub(super) fn preference(&self, first: i32, second: i32) -> f64 {
        let place = |offset: i32| ((TURN - offset).clamp(-REACH, REACH) + REACH) as usize;
        let (first, second) = (place(first), place(second));
        z_over_days(self.days.iter().map(|day| day[first] - day[second]))
    }

    /// The insulin clock's offset, with a 95 % interval over days and over people's turns; `None`
    /// with fewer than ten corrections.
    pub(super) fn delay(&self) -> Option<Minutes95> {
        if self.count < FEWEST_FOR_ESTIMATE {
            return None;
        }
        let found =
            Minutes95::bootstrapped(&self.days, REPLICATES, |drawn| Some(delay(&total(drawn))))?;
        Some(found.with_error(TURN_SD))
    }
}

/// The offset at which the turn is sharpest, min.
fn delay(table: &[f64; BINS]) -> f64 {
    let (place, _) = highest(2..BINS - 2, |place| under_triangle(table, place, 2));
    5.0 * (f64::from(TURN + REACH) - place as f64)
}

#[cfg(test)]
mod tests {
    use cohort::{Channel, Person};

    use super::*;
    use crate::quality::tests::person_with;

    /// A fortnight in which glucose rises and falls in tents, a bolus 20 min before each peak but
    /// recorded `steps` late, and a meal with a bolus in every valley.
    fn tents(steps: usize) -> Person {
        let mut person = person_with(Channel::Bolus, &[]);
        let n = person.record.len();
        let cgm = person.record.channel_mut(Channel::Cgm).iter_mut().enumerate();
        cgm.for_each(|(k, value)| *value = Some(220.0 - 2.0 * (k % 96).abs_diff(48) as f64));
        for start in (0..n - 96).step_by(96) {
            let bolus = person.record.channel_mut(Channel::Bolus);
            bolus[start + 44 + steps] = Some(2.0);
            bolus[start + 4 + steps] = Some(4.0);
            person.record.channel_mut(Channel::Carbs)[start + 4] = Some(40.0);
        }
        person
    }

    #[test]
    fn the_turn_tells_the_offset_and_meals_are_left_aside() {
        for steps in [0, 6, 12] {
            let person = tents(steps);
            let apart = i32::try_from(steps).expect("small");
            let found = Corrections::of(&DoseSteps::of(&person), apart).expect("corrections");
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
        let mut person = tents(0);
        person.record = person.record.slice(0..300).expect("inside the record");
        assert!(Corrections::of(&DoseSteps::of(&person), 0).is_none());
    }
}
