//! What recorded insulin and carbohydrate show by themselves: how they vary, and what stands alone on the log.

use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::{LEAST_MEAL, Values, excess_kurtosis, moment_of_fewer, sd, skewness};
use crate::calibrated_person::CalibratedPerson;
use crate::units::{Doses, power};

/// Blocks of six hours are fewer than readings by so much.
const QUARTERS: usize = 4;
/// Least dose of a bolus that would cover a meal, U.
const BOLUS: f64 = 1.0;
/// Glucose that nobody corrects, mg/dL.
const NOT_HIGH: f64 = 140.0;

/// A moment of some values.
type Moment = fn(&[f64]) -> f64;

impl Values {
    pub(super) fn doses(&mut self, person: &CalibratedPerson<'_>) {
        let quarters = Doses::of_person(person).by_quarter();
        let known: Vec<f64> = quarters.iter().flatten().copied().collect();
        let moments: [(&str, Moment); 3] =
            [("SD", sd), ("skewness", skewness), ("kurtosis", excess_kurtosis)];
        for (name, of) in moments {
            let name = format!("record/insulin of 6 h over usual {name}");
            self.set(&name, moment_of_fewer(&known, QUARTERS, of));
        }
        let days: Vec<f64> =
            quarters.chunks(QUARTERS).map(|day| day.iter().flatten().sum()).collect();
        self.set("record/insulin power at 3 days", Some((power(&days, 3) + 0.01).ln()));
        let inputs = &person.observations.inputs;
        let around =
            |k: usize, steps: usize| k.saturating_sub(steps)..(k + steps).min(inputs.len());
        // Steps around which every dose is on record: beside others nobody knows what stood alone.
        let judged = |steps: usize| {
            let recorded = &person.observations.doses_recorded;
            (0..inputs.len()).filter(move |k| recorded[around(*k, steps)].iter().all(|r| *r))
        };
        let per_day = |count: usize, steps: usize| {
            let days = judged(steps).count() as f64 / STEPS_PER_DAY as f64;
            (days > 0.0).then(|| count as f64 / days)
        };
        let alone = || {
            judged(STEPS_PER_HOUR).filter(|k| {
                let beside = &inputs[around(*k, STEPS_PER_HOUR)];
                inputs[*k].bolus.0 >= BOLUS && beside.iter().all(|input| input.carbs.0 <= 0.0)
            })
        };
        let rate = per_day(alone().count(), STEPS_PER_HOUR);
        self.set("record/boluses without carbohydrate, 1/day", rate);
        let glucose = person.calibration.glucose();
        let no_correction = alone().filter(|k| glucose[*k] < NOT_HIGH).count();
        let name = format!("record/boluses without carbohydrate below {NOT_HIGH} mg/dL, 1/day");
        self.set(&name, per_day(no_correction, STEPS_PER_HOUR));
        let uncovered = judged(STEPS_PER_HOUR / 2).filter(|k| {
            let beside = &inputs[around(*k, STEPS_PER_HOUR / 2)];
            inputs[*k].carbs.0 >= LEAST_MEAL && beside.iter().all(|input| input.bolus.0 <= 0.0)
        });
        let rate = per_day(uncovered.count(), STEPS_PER_HOUR / 2);
        self.set("record/meals without a bolus, 1/day", rate);
    }
}
