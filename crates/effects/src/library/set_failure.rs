//! An infusion set that fails: next to no insulin arrives until it is replaced.

use super::prelude::*;

/// Share of the insulin that no longer arrives, in a failure of size 1.
const LOST: f64 = 0.85;
/// How long a failure lasts, min: two to three hours of rise and five above 250 mg/dL before the set is changed.
const LASTS: f64 = 480.0;
/// Onsets are tried this far apart, min: a quarter of an hour is not resolved over eight hours.
const ONSETS_APART: f64 = 15.0;
/// Failures a day: 3.3 % of sets worn three days.
const PER_DAY: f64 = 0.011;
/// Relative sizes and their weights: 15 % or 30 % still arrive.
const SIZES: [(f64, f64); 2] = [(1.0, 0.6), (0.82, 0.4)];

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct SetFailure;

impl Effect for SetFailure {
    fn card(&self) -> Card {
        Card {
            id: EffectId::SET_FAILURE,
            port: Port::InsulinInput,
            summary: "a kinked, leaking or clogged infusion set delivers next to nothing until it is replaced",
            size_at_one: "15 to 30 % of the insulin still arrives for 8 h, 3.3 % of sets",
            source: "3.3 % of 22,741 sets, 5.1 h above 250 mg/dL before removal: Kanapka et al., Diabetes Technol Ther \
                     2022;24:396",
            signature: "glucose under-predicted ever more for many hours from one moment on, whatever is delivered",
            channels: &[Channel::Insulin],
            confusable_with: &[
                EffectId::MISSED_MEALS,
                EffectId::SET_AGEING,
                EffectId::SENSOR_DRIFT,
            ],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.1, largest: 1.15 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        EventShape {
            field: Field::InsulinInput,
            profiles: vec![vec![-LOST; meals::steps(LASTS)]],
            onsets: (0..course.len()).step_by(meals::steps(ONSETS_APART)).collect(),
            per_day: PER_DAY,
            sizes: SIZES.to_vec(),
        }
        .if_it_starts()
    }

    fn modulate(&self, _: usize, _: f64, _: &Course, _: &mut [Modulation]) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::fortnight;

    #[test]
    fn the_largest_failure_leaves_no_less_than_nothing() {
        let Some(Form::Events(events)) = SetFailure.form(&fortnight()) else {
            panic!("a set can always fail");
        };
        assert_eq!(events.profiles[0].len(), 96);
        let deepest = events.profiles[0].iter().copied().fold(0.0, f64::min);
        let largest = SIZES.iter().map(|(size, _)| *size).fold(0.0, f64::max);
        assert!(deepest < 0.0 && 1.0 + deepest * largest * SetFailure.card().prior.largest >= 0.0);
    }
}
