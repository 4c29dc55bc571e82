//! Steps of free runs that are prepared once, where nothing that acts in them depends on the run.
//!
//! Runs start every two hours and last a day, so that each step is taken a dozen times. They have a loop of their own,
//! because [`simulate`](physiology::simulate) keeps every state and its plant would compute every coefficient again.

use std::ops::Range;

use effects::{Field, Modulation};
use ode_sim::OdeVector;
use physiology::{MgPerDl, Plant as _, StepInput, UnitsPerHour};

use crate::filter::augmented::{AugmentedModel, Euler, Stepper};
use crate::filter::observations::within_sensor_range;
use crate::filter::state::AugmentedState;

/// The steps of a stretch of a record.
pub(super) struct PreparedSteps<'a> {
    model: &'a AugmentedModel,
    /// Number of the first step.
    first: usize,
    steps: Vec<PreparedStep>,
    /// The step of the body under each of the modulations that follow each other.
    bodies: Vec<Euler>,
}

struct PreparedStep {
    /// Index of its body.
    body: usize,
    /// What enters S1 and C1.
    doses: [f64; 2],
    /// Added to dQ1/dt, mmol/kg/min.
    flux: f64,
    /// Share of the distance between interstitial and plasma glucose that is left after the step.
    lag_decay: f64,
    /// What a sensor makes of interstitial glucose at the start of the step: factor, and mg/dL beside.
    shown: (f64, f64),
    /// Whether a body at rest takes it as the Euler step.
    covered: bool,
}

impl<'a> PreparedSteps<'a> {
    /// `None` for a body other than the ODE, and where a modulation acts by glucose. Beyond the end of `modulations`
    /// nothing is changed.
    pub(super) fn of(
        model: &'a AugmentedModel,
        inputs: &[StepInput],
        modulations: &[Modulation],
        range: Range<usize>,
    ) -> Option<Self> {
        let (anywhere, _) = model.start(UnitsPerHour(0.0), MgPerDl(120.0));
        let steps = Vec::with_capacity(range.len());
        let mut prepared = Self { model, first: range.start, steps, bodies: Vec::new() };
        for step in range {
            let input = &inputs[step];
            let modulation = modulations.get(step).unwrap_or(Modulation::unchanged());
            if BY_GLUCOSE.iter().any(|field| modulation[*field] != field.neutral()) {
                return None;
            }
            let acting = model.acting(&anywhere, input, modulation);
            let Stepper::Ode(euler) = acting.stepper else { return None };
            if prepared.bodies.last() != Some(&euler) {
                prepared.bodies.push(euler);
            }
            prepared.steps.push(PreparedStep {
                body: prepared.bodies.len() - 1,
                doses: euler.doses(&acting.input),
                flux: modulation[Field::Flux],
                lag_decay: acting.lag_decay,
                shown: (modulation[Field::SensorGain], modulation[Field::SensorOffset]),
                covered: Euler::covers(&anywhere.body, input),
            });
        }
        Some(prepared)
    }

    /// What a sensor would show in a run from the start of a step, mg/dL, one entry a step and one for the end.
    ///
    /// `filtered` is where the run starts, without the flux and the sensor error. `None` where a step on the way is not
    /// among those worked out, or where the run breaks.
    pub(super) fn readings(
        &self,
        start: usize,
        filtered: &AugmentedState,
        steps: usize,
    ) -> Option<Vec<f64>> {
        let from = start.checked_sub(self.first)?;
        // The reading at the end belongs to the step after the last.
        let on_the_way = self.steps.get(from..=from + steps)?;
        if !Euler::covers(&filtered.body, &StepInput::default()) {
            return None;
        }
        let person = self.model.person();
        let glucose = |x: &OdeVector| person.glucose(&filtered.body.with_vector(x)).0;
        let mut x = filtered.body.vector();
        let (mut before, mut interstitial) = (glucose(&x), filtered.interstitial.0);
        let mut readings = Vec::with_capacity(steps + 1);
        for (index, step) in on_the_way.iter().enumerate() {
            let (gain, offset) = step.shown;
            readings.push(within_sensor_range(interstitial * gain + offset));
            if index == steps {
                break;
            }
            if !step.covered {
                return None;
            }
            x = OdeVector(self.bodies[step.body].step(&x.0, step.doses, step.flux));
            let after = glucose(&x);
            let plasma = 0.5 * (before + after);
            interstitial = plasma + (interstitial - plasma) * step.lag_decay;
            before = after;
        }
        let finite = x.first_non_finite().is_none() && interstitial.is_finite();
        finite.then_some(readings)
    }
}

/// Fields whose effect depends on glucose at the time.
const BY_GLUCOSE: [Field; 3] =
    [Field::LowGlucoseProduction, Field::RenalRate, Field::RenalThreshold];

#[cfg(test)]
mod tests {
    use physiology::{Grams, Kilograms, Units};

    use super::super::sample;
    use super::*;
    use crate::modulated_plant::ModulatedPlant;

    const STEPS: usize = 60;

    fn inputs() -> Vec<StepInput> {
        (0..STEPS + 10)
            .map(|k| StepInput {
                basal: UnitsPerHour(0.8 + 0.1 * (k % 5) as f64),
                bolus: Units(if k == 20 { 5.0 } else { 0.0 }),
                carbs: Grams(if k == 21 { 60.0 } else { 0.0 }),
                ..StepInput::default()
            })
            .collect()
    }

    fn modulations(field: Field) -> Vec<Modulation> {
        (0..STEPS + 10)
            .map(|k| {
                let mut modulation = Modulation::NEUTRAL;
                if (25..50).contains(&k) {
                    modulation[field] = field.neutral() + 0.01 * (k / 4) as f64;
                }
                modulation
            })
            .collect()
    }

    #[test]
    fn readings_are_those_of_the_modulated_plant() {
        let model = sample::model(Kilograms(76.3));
        let (state, _) = model.start(UnitsPerHour(1.0), MgPerDl(150.0));
        let inputs = inputs();
        for field in Field::ALL {
            let modulations = modulations(field);
            let prepared = PreparedSteps::of(&model, &inputs, &modulations, 5..inputs.len());
            if BY_GLUCOSE.contains(&field) {
                assert!(prepared.is_none(), "{field:?}");
                continue;
            }
            let readings = prepared.expect("prepared").readings(7, &state, STEPS);
            let plant = ModulatedPlant::new(&model, &modulations);
            let mut at = ModulatedPlant::start(7, &state);
            for (index, reading) in readings.expect("covered").into_iter().enumerate() {
                assert_eq!(reading, plant.reading(&at), "{field:?}, step {index}");
                at = plant.step(&at, &inputs[at.step]).expect("finite");
            }
        }
    }

    #[test]
    fn what_was_not_worked_out_is_not_run() {
        let model = sample::model(Kilograms(70.0));
        let (state, _) = model.start(UnitsPerHour(1.0), MgPerDl(150.0));
        let inputs = inputs();
        let prepared = PreparedSteps::of(&model, &inputs, &[], 5..30).expect("nothing acts");
        assert_eq!(prepared.readings(5, &state, 24).map(|readings| readings.len()), Some(25));
        assert_eq!(prepared.readings(5, &state, 25), None);
        assert_eq!(prepared.readings(4, &state, 3), None);
        let broken = AugmentedState { interstitial: MgPerDl(f64::NAN), ..state };
        assert_eq!(prepared.readings(5, &broken, 3), None);
    }
}
