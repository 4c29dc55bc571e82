//! Exercise while it lasts: working muscle takes up glucose.

use super::prelude::*;

/// Fractional uptake of plasma glucose for each beat over rest, 1/min per 1/min.
///
/// Breton, J Diabetes Sci Technol 2008;2:169, fitted to 21 people on a clamp.
const BETA: f64 = 3.39e-4;
/// Time in which uptake follows heart rate, min (the same).
const TAU_HEART_RATE: f64 = 5.0;
/// Time in which uptake follows intensity in the active tissue, min (Resalat et al. 2019).
const TAU_TISSUE: f64 = 30.0;
/// Glucose distribution volume, L/kg (Hovorka et al. 2004).
const V_G: f64 = 0.16;
/// mg/dL in a mmol/L.
const MG_DL_PER_MMOL_L: f64 = 18.0;
/// Heart rate reserve, 1/min: 100 % of maximal oxygen uptake (Swain & Leutholtz 1997).
const RESERVE: f64 = 110.0;
/// Active muscle share: legs, 0.3 to 0.6 in the authors' simulator.
const ACTIVE_SHARE: f64 = 0.45;
/// Scale of the tissue's uptake in peripheral uptake, mg/min (Resalat et al. 2019).
const PERIPHERAL: f64 = 35.0;
/// Gain of insulin uptake by the active share (the same).
const INSULIN_GAIN: f64 = 2.4;
/// Heart rate over rest from which catecholamines raise production against uptake, 1/min: about
/// 60 % of the reserve.
const HARD: f64 = 65.0;
/// Heart rate over rest at which glucose no longer falls, 1/min (Marliss & Vranic, Diabetes 2002;51:S271).
const ALL_OUT: f64 = 110.0;

/// What carries the uptake.
#[derive(Debug, Clone, Copy)]
enum Shape {
    /// Insulin-independent, in proportion to heart rate over rest.
    Uptake,
    /// The same, but less of it in hard exercise.
    UptakeLessWhenHard,
    /// Insulin action up with intensity.
    Action,
}

/// What is tried, in the order of the variants.
const SHAPES: [Shape; 3] = [Shape::Uptake, Shape::Action, Shape::UptakeLessWhenHard];

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct Exercise;

impl Effect for Exercise {
    fn card(&self) -> Card {
        Card {
            id: EffectId::EXERCISE,
            port: Port::GlucoseFlux,
            summary: "working muscle takes up glucose, with little need of insulin, while exercise lasts",
            size_at_one: "3.4e-4 of plasma glucose a minute for each heart beat over rest: about 2.5 mg/dL/min \
                          at 50 over rest and 150 mg/dL",
            source: "uptake: Breton, J Diabetes Sci Technol 2008;2:169; as part of a simulator: Deichmann et al., PLoS \
                     Comput Biol 2023;19:e1010289; action: Resalat et al., PLoS One 2019;14:e0217301; hard exercise: Marliss & \
                     Vranic, Diabetes 2002;51:S271",
            signature: "glucose over-predicted from minutes after the onset of activity to half an hour after its \
                        end",
            channels: &[Channel::Activity, Channel::Glucose],
            confusable_with: &[EffectId::POST_EXERCISE_SENSITIVITY],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.7, largest: 4.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        activity::known(course).then_some(Form::Driven)
    }

    fn variants(&self) -> usize {
        SHAPES.len()
    }

    fn modulate(&self, variant: usize, amplitude: f64, course: &Course, into: &mut [Modulation]) {
        if !activity::known(course) {
            return;
        }
        let intensity = activity::intensity(course);
        match SHAPES[variant % SHAPES.len()] {
            Shape::Uptake => uptake(&intensity, amplitude, course, into),
            Shape::UptakeLessWhenHard => {
                let effective: Vec<f64> = intensity.iter().map(|y| less_when_hard(*y)).collect();
                uptake(&effective, amplitude, course, into);
            }
            Shape::Action => action(&intensity, amplitude, into),
        }
    }
}

/// Insulin-independent uptake beta Y Q1, with Y following the intensity.
fn uptake(intensity: &[f64], amplitude: f64, course: &Course, into: &mut [Modulation]) {
    let keep = (-STEP_MINUTES / TAU_HEART_RATE).exp();
    let mut y = 0.0;
    for ((now, glucose), modulation) in intensity.iter().zip(&course.glucose).zip(into) {
        y = now + (y - now) * keep;
        modulation[Field::Flux] -= amplitude * BETA * y * V_G * glucose / MG_DL_PER_MMOL_L;
    }
}

/// Intensity that lowers glucose: it turns back above hard exercise and is 0 when all out.
fn less_when_hard(intensity: f64) -> f64 {
    if intensity <= HARD {
        intensity
    } else {
        HARD * ((ALL_OUT - intensity) / (ALL_OUT - HARD)).max(0.0)
    }
}

/// Action factor `M_PGU` `M_PIU` of Resalat et al., the active share growing with intensity.
fn action(intensity: &[f64], amplitude: f64, into: &mut [Modulation]) {
    let keep = (-STEP_MINUTES / TAU_TISSUE).exp();
    let mut tissue = 0.0;
    for (now, modulation) in intensity.iter().zip(into) {
        let v = 100.0 * now / RESERVE;
        let steady = (0.006 * v * v + 1.2264 * v - 10.1958).max(0.0);
        tissue = steady + (tissue - steady) * keep;
        let share = ACTIVE_SHARE * (v / 50.0).min(1.0);
        let factor = (1.0 + tissue * ACTIVE_SHARE / PERIPHERAL) * (1.0 + INSULIN_GAIN * share);
        modulation[Field::Action] *= 1.0 + amplitude * (factor - 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{BOUT, fortnight, modulated};

    #[test]
    fn glucose_leaves_during_a_bout_and_not_before() {
        let course = fortnight();
        for variant in 0..Exercise.variants() {
            let steps = modulated(&Exercise, variant, 1.0, &course);
            let working = steps[BOUT + 6];
            assert!(
                working[Field::Flux] < 0.0 || working[Field::Action] > 1.0,
                "variant {variant}"
            );
            assert!(steps[BOUT - 1].is_neutral());
        }
    }

    #[test]
    fn half_an_hour_at_fifty_over_rest_takes_out_what_was_published() {
        let course = fortnight();
        let flux = modulated(&Exercise, 0, 1.0, &course)[BOUT + 6][Field::Flux];
        let glucose = course.glucose[BOUT + 6];
        // beta x 50 of plasma glucose a minute, in mg/dL/min; the heart rate has settled (six time
        // constants, e^-6 = 0.25 %).
        let fall = flux / V_G * MG_DL_PER_MMOL_L;
        assert!((fall / (-BETA * 50.0 * glucose) - 1.0).abs() < 0.005, "{fall}");
    }

    #[test]
    fn all_out_effort_lowers_nothing() {
        assert_eq!(less_when_hard(50.0), 50.0);
        assert!(less_when_hard(90.0) < less_when_hard(65.0));
        assert_eq!(less_when_hard(120.0), 0.0);
    }

    #[test]
    fn steps_stand_in_for_heart_rate_and_without_both_there_is_no_form() {
        let mut course = fortnight();
        course.heart_rate_over_rest = None;
        assert!(modulated(&Exercise, 0, 1.0, &course)[BOUT + 6][Field::Flux] < 0.0);
        course.walked = None;
        assert_eq!(Exercise.form(&course), None);
    }
}
