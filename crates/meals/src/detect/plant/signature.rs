//! By which course a gram eaten at a step shifts the whitened innovations that follow.

use ode_sim::gut::{GutPair, glucose_dose};
use physiology::{Grams, STEP};

use crate::detect::plant::filter::{Innovations, STATES};
use crate::detect::plant::insulin::InsulinAction;

/// Times to the maximal appearance of a meal that are tried, min: the plant's 40 and, since meals
/// and people differ, a quick and a slow one.
pub const GUT_TIMES: [f64; 3] = [30.0, 40.0, 55.0];

/// Appearance of one gram in the blood, by time constant of the gut: the mean flux into Q1 through
/// each step after eating, mmol/kg/min.
pub(crate) fn appearances(action: &InsulinAction, horizon: usize) -> [Vec<f64>; GUT_TIMES.len()] {
    let plant = &action.plant;
    let dose = plant.parameters.a_g * glucose_dose(Grams(1.0), plant.weight);
    GUT_TIMES.map(|time| {
        let mut gut = GutPair::default().fed(dose);
        (0..horizon)
            .map(|_| {
                let after = gut.after(STEP.0, time);
                let appeared = (gut.c1 + gut.c2 - after.c1 - after.c2) / STEP.0;
                gut = after;
                appeared
            })
            .collect()
    })
}

/// Fills `signature` with the shift of the whitened innovations of the steps after `eaten`, per
/// gram; 0 where there is no reading or no step any more.
pub(crate) fn follow(
    eaten: usize,
    appearance: &[f64],
    action: &InsulinAction,
    innovations: &Innovations,
    signature: &mut [f64],
) {
    let mut shift = [0.0; STATES];
    signature.fill(0.0);
    for (k, (flux, slot)) in appearance.iter().zip(signature).enumerate() {
        let Some(step) = action.steps.get(eaten + k) else { return };
        shift = innovations.filter.advance(step, &shift, *flux);
        let Some(Some(update)) = innovations.updates.get(eaten + k + 1) else { continue };
        let shown = innovations.filter.shows(&shift);
        *slot = shown / update.sd;
        for (state, gain) in shift.iter_mut().zip(update.gain) {
            *state -= gain * shown;
        }
    }
}

#[cfg(test)]
mod tests {
    use cohort::Channel;
    use ode_sim::OdePlant;
    use physiology::{MgPerDl, Plant as _, StepInput};

    use super::*;
    use crate::detect::plant::FilterNoise;
    use crate::detect::plant::synthetic::person;
    use crate::signals::Signals;

    #[test]
    fn all_of_a_gram_appears() {
        let person = person(30, &[], &[]);
        let signals = Signals::of(&person).expect("values that can be");
        let action = InsulinAction::along(&signals, 1.0).expect("a plant that runs");
        let dose = 0.8 * 1.0 / (0.18 * 76.3); // A_G D of one gram, mmol/kg
        for (appearance, time) in appearances(&action, 300).iter().zip(GUT_TIMES) {
            let sum: f64 = appearance.iter().map(|flux| flux * 5.0).sum();
            // What is left after 25 h is below 1e-9 even of the slowest gut.
            assert!((sum / dose - 1.0).abs() < 1e-9, "{time}: {sum}");
        }
    }

    #[test]
    fn a_signature_is_what_the_plants_own_meal_does_to_the_innovations() {
        // The plant at rest, with and without ten grams at step 100; its gut has the second of
        // the times. Readings are the glucose of both behind a lag of 8 min, not rounded.
        let eaten = 100;
        let (mut with, mut without) = (person(160, &[], &[]), person(160, &[], &[]));
        let plant = OdePlant {
            integrator: ode_sim::Integrator::RungeKutta4 { substeps: 4 },
            ..OdePlant::reproduction(ode_sim::OdeParameters::nominal(), with.weight.expect("set"))
        };
        let start =
            ode_sim::steady_state::at_glucose(&plant.parameters, plant.weight, MgPerDl(120.0))
                .expect("a glucose that can be held");
        for (person, grams) in [(&mut with, 10.0), (&mut without, 0.0)] {
            let (mut state, mut tissue) = (start.state, 120.0);
            for step in 0..160 {
                person.record.channel_mut(Channel::Cgm)[step] = Some(tissue);
                let carbs = Grams(if step == eaten { grams } else { 0.0 });
                let input = StepInput { basal: start.basal, carbs, ..StepInput::default() };
                let before = plant.glucose(&state).0;
                state = plant.step(&state, &input).expect("a plant that runs");
                let slope = (plant.glucose(&state).0 - before) / 300.0;
                for second in 0..300 {
                    tissue += (before + slope * f64::from(second) - tissue) / (8.0 * 60.0);
                }
            }
        }
        let noise = FilterNoise::working();
        let quiet = Signals::of(&without).expect("values that can be");
        let action = InsulinAction::along(&quiet, 1.0).expect("a plant that runs");
        let base = Innovations::of(&quiet, &action, &noise);
        let fed = Signals::of(&with).expect("values that can be");
        let moved = Innovations::of(&fed, &action, &noise);
        let difference: Vec<f64> = moved
            .whitened()
            .zip(base.whitened())
            .map(|(a, b)| a.unwrap_or(0.0) - b.unwrap_or(0.0))
            .collect();
        let mut signature = vec![0.0; 36];
        let nominal = GUT_TIMES.iter().position(|t| *t == 40.0).expect("the plant's own");
        let appearance = &appearances(&action, 36)[nominal];
        follow(eaten, appearance, &action, &base, &mut signature);
        let largest = signature.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
        assert!(largest > 0.005, "{largest}");
        for (k, (found, expected)) in signature.iter().zip(&difference[eaten + 1..]).enumerate() {
            // Ten grams bend the plant a little (renal clearance is not reached), steps of a
            // second bend the lag, trapezoids the flux: three hundredths of the largest value.
            assert!((10.0 * found - expected).abs() < 0.03 * 10.0 * largest, "step {k}");
        }
        assert!(difference[..=eaten].iter().all(|d| d.abs() < 1e-9), "nothing comes before it");
    }
}
