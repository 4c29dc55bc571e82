//! Recorded insulin beside what is usual for the person at the same time of day.

use std::ops::Range;

use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use crate::calibrated_person::CalibratedPerson;

/// Share of the usual amount that is added to both sides of a ratio, so that no insulin has a logarithm.
const FLOOR: f64 = 0.2;

/// Insulin of a record, basal and bolus together. Steps whose insulin nobody recorded count neither here nor there.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Doses {
    /// U up to each step, what is usual at its time of day, and steps that are not on record; one entry more than steps.
    sums: Vec<[f64; 3]>,
}

impl Doses {
    /// Of a person's record.
    pub(crate) fn of_person(person: &CalibratedPerson<'_>) -> Self {
        let record = &person.person.record;
        let injects = record.basal().iter().all(Option::is_none);
        let inputs = person.observations.inputs.iter().enumerate();
        let units = inputs
            .map(|(k, input)| {
                let known = (injects || record.basal()[k].is_some()) && record.bolus()[k].is_some();
                known.then(|| input.insulin().0 / STEPS_PER_HOUR as f64)
            })
            .collect();
        let hours: Vec<f64> = (0..record.len()).map(|k| f64::from(record.hour(k))).collect();
        Self::of(&hours, units)
    }

    /// Of insulin by step, U, where it is on record, and the hour of each step.
    pub(crate) fn of(hours: &[f64], units: Vec<Option<f64>>) -> Self {
        let hour = |k: usize| (hours[k] as usize).min(23);
        let mut usual = [[0.0; 2]; 24];
        for (k, value) in units.iter().enumerate() {
            let [sum, count] = &mut usual[hour(k)];
            if let Some(value) = value {
                *sum += value;
                *count += 1.0;
            }
        }
        let mut sum = [0.0; 3];
        let mut sums = Vec::with_capacity(units.len() + 1);
        sums.push(sum);
        for (k, value) in units.into_iter().enumerate() {
            let [total, count] = usual[hour(k)];
            match value {
                Some(value) => sum = [sum[0] + value, sum[1] + total / count, sum[2]],
                None => sum[2] += 1.0,
            }
            sums.push(sum);
        }
        Self { sums }
    }

    /// Logarithm of the insulin of some steps over what is usual at their time of day; 0 where none ever is.
    pub(crate) fn over_usual(&self, steps: &Range<usize>) -> f64 {
        let [given, usual, _] = self.over(steps);
        if usual > 1e-6 { ((given + FLOOR * usual) / ((1.0 + FLOOR) * usual)).ln() } else { 0.0 }
    }

    /// [`over_usual`](Self::over_usual) of every six hours from the start on that are on record.
    pub(crate) fn by_quarter(&self) -> Vec<Option<f64>> {
        let length = STEPS_PER_DAY / 4;
        let starts = (0..self.sums.len().saturating_sub(length)).step_by(length);
        let quarters = starts.map(|start| start..start + length);
        quarters
            .map(|steps| (self.over(&steps)[2] <= 0.0).then(|| self.over_usual(&steps)))
            .collect()
    }

    fn over(&self, steps: &Range<usize>) -> [f64; 3] {
        std::array::from_fn(|k| self.sums[steps.end][k] - self.sums[steps.start][k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn insulin_is_held_against_the_same_hours_of_other_days() {
        let hours: Vec<f64> = (0..4 * STEPS_PER_DAY)
            .map(|k| (k % STEPS_PER_DAY) as f64 / STEPS_PER_HOUR as f64)
            .collect();
        // Twice as much by day as by night, and twice as much again on the afternoon of the third day.
        let usual = |k: usize| if hours[k] >= 6.0 { 0.1 } else { 0.05 };
        let mut units: Vec<f64> = (0..hours.len()).map(usual).collect();
        let afternoon = 2 * STEPS_PER_DAY + 144..2 * STEPS_PER_DAY + 216;
        units[afternoon.clone()].iter_mut().for_each(|value| *value *= 2.0);
        let doses = Doses::of(&hours, units.iter().copied().map(Some).collect());
        // Four days' mean of that afternoon is 1.25 of the others.
        let expected = |ratio: f64| ((ratio + FLOOR) / (1.0 + FLOOR)).ln();
        assert!((doses.over_usual(&afternoon) - expected(2.0 / 1.25)).abs() < 1e-9);
        assert!(doses.over_usual(&(0..72)).abs() < 1e-9);
        assert_eq!(doses.by_quarter().len(), 16);
        let none = Doses::of(&hours, vec![Some(0.0); hours.len()]);
        assert_eq!(none.over_usual(&(0..72)), 0.0);
        // What nobody recorded is not little insulin.
        let gap = 72..3 * 72;
        let known = |k: usize| if gap.contains(&k) { None } else { Some(usual(k)) };
        let doses = Doses::of(&hours, (0..hours.len()).map(known).collect());
        assert!(doses.over_usual(&(36..108)).abs() < 1e-9);
        let quarters = doses.by_quarter();
        assert_eq!(
            quarters.iter().map(Option::is_none).collect::<Vec<_>>()[..4],
            [false, true, true, false]
        );
    }
}
