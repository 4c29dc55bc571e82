//! After exercise: insulin acts more strongly for half a day.

use super::prelude::*;

/// Action after a full dose of exercise at amplitude 1, as a factor.
const FACTOR: f64 = 1.3;
/// Heart rate over rest at which exercise counts once, 1/min.
const MODERATE: f64 = 50.0;
/// Most that intensity counts.
const MOST_INTENSITY: f64 = 1.5;
/// A full dose: so many minutes of moderate exercise.
const FULL_DOSE: f64 = 45.0;
/// Most doses that act.
const MOST_DOSES: f64 = 2.0;

/// How the sensitivity comes and goes.
#[derive(Debug, Clone, Copy)]
struct Tail {
    /// Time constant of its decay, min.
    tau: f64,
    /// Whether it comes as late as it goes (a second peak 7 to 11 h later, by night).
    delayed: bool,
    /// Whether the liver takes part.
    liver: bool,
}

/// What is tried, in the order of the variants.
const TAILS: [Tail; 4] = [
    Tail { tau: 600.0, delayed: false, liver: false },
    Tail { tau: 960.0, delayed: false, liver: false },
    Tail { tau: 600.0, delayed: false, liver: true },
    Tail { tau: 360.0, delayed: true, liver: false },
];

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct PostExerciseSensitivity;

impl Effect for PostExerciseSensitivity {
    fn card(&self) -> Card {
        Card {
            id: EffectId::POST_EXERCISE_SENSITIVITY,
            port: Port::InsulinAction,
            summary: "insulin acts more strongly for half a day after exercise",
            size_at_one: "action 30 % higher after 45 min of moderate exercise, decaying over 10 h",
            source: "20 to 50 % over 10 to 16 h: Mikines et al., Am J Physiol 1988;254:E248; late peak after 7 to \
                     11 h: McMahon et al., J Clin Endocrinol Metab 2007;92:963; tail of 600 min: Breton, J \
                     Diabetes Sci Technol 2008;2:169",
            signature: "glucose over-predicted in the evening and night after active days, not after others",
            channels: &[Channel::Activity],
            confusable_with: &[EffectId::EXERCISE, EffectId::SLEEP_LOSS, EffectId::ALCOHOL],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 4.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        activity::known(course).then_some(Form::Driven)
    }

    fn variants(&self) -> usize {
        TAILS.len()
    }

    fn modulate(&self, variant: usize, amplitude: f64, course: &Course, into: &mut [Modulation]) {
        if !activity::known(course) {
            return;
        }
        let tail = TAILS[variant % TAILS.len()];
        let centred = centre_within_clock_slots(course, &doses(tail, course));
        for (dose, modulation) in centred.iter().zip(into) {
            let factor = (amplitude * FACTOR.ln() * dose).exp();
            modulation[Field::Action] *= factor;
            if tail.liver {
                modulation[Field::LiverAction] *= factor;
            }
        }
    }
}

/// Doses of exercise that still act in each step. Always known: a gap in the record is no exercise.
fn doses(tail: Tail, course: &Course) -> Vec<Option<f64>> {
    let keep = (-STEP_MINUTES / tail.tau).exp();
    let (mut early, mut late) = (0.0_f64, 0.0_f64);
    activity::intensity(course)
        .iter()
        .map(|intensity| {
            let dose = (intensity / MODERATE).min(MOST_INTENSITY) * STEP_MINUTES / FULL_DOSE;
            early = early * keep + dose;
            late = late * keep + early * (1.0 - keep);
            // The late course of a single dose peaks at 1/e.
            let acting = if tail.delayed { std::f64::consts::E * late } else { early };
            Some(acting.min(MOST_DOSES))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{
        BOUT, BOUT_STEPS, DAY, fortnight, looks_only_back, modulated, zero_mean_by_slot,
    };

    #[test]
    fn action_is_up_in_the_night_after_a_bout_and_down_after_a_quiet_day() {
        let course = fortnight();
        for variant in 0..PostExerciseSensitivity.variants() {
            let steps = modulated(&PostExerciseSensitivity, variant, 1.0, &course);
            let after = BOUT + BOUT_STEPS + 72;
            assert!(steps[after][Field::Action] > 1.0, "variant {variant}");
            assert!(steps[after - DAY][Field::Action] < 1.0, "variant {variant}");
            zero_mean_by_slot(&course, &steps, Field::Action);
        }
    }

    #[test]
    fn a_full_dose_is_one_and_decays_as_stated() {
        let course = fortnight();
        let acting = doses(TAILS[0], &course);
        let end = acting[BOUT + BOUT_STEPS - 1].expect("always known");
        let later = acting[BOUT + BOUT_STEPS - 1 + 120].expect("always known");
        // Less than 1 by what decays within the 45 minutes (half of 45/600).
        assert!((0.94..=1.0).contains(&end), "{end}");
        // Ten hours later 1/e is left: the recursion is exact, so rounding only.
        assert!((later / end - (-1.0_f64).exp()).abs() < 1e-9);
    }

    #[test]
    fn the_driver_looks_only_back() {
        for tail in TAILS {
            looks_only_back(|course| doses(tail, course));
        }
    }
}
