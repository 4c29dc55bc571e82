//! An effect as an input of the population network: what its modulations do to a window before any
//! residual network has a say.

use std::sync::Arc;

use anyhow::{Context as _, Result};
use cohort::Person;
use effects::{Course, Effect, Form, Modulation};
use gap::augmented::{AugmentedModel, AugmentedState};
use gap::{NoiseModel, course};
use nn_statespace::{GLUCOSE_RANGE, PopulationModel, ScaledStates};
use ode_sim::{EgpMode, OdeParameters, OdeState, OdeVector};
use physiology::{
    Compartment, Kilograms, MG_PER_DL_PER_MMOL_PER_L, MgPerDl, Plant as _, STEP, StepInput,
    UnitsPerHour,
};
use twins::Known;

use crate::bodies::NetworkBody;

/// Glucose at which drivers are compared to see whether they read it, mg/dL.
const PROBES: [f64; 2] = [60.0, 240.0];

/// An effect with the variant and the amplitude by which it acts in everybody who has one.
#[derive(Debug)]
pub(crate) struct Acting {
    pub(crate) effect: Box<dyn Effect>,
    pub(crate) variant: usize,
}

/// The course of a person's record from which drivers are made. Glucose is left out: what an input
/// knows of it ahead of a window's start, a simulation must not.
pub(crate) fn course_without_glucose(person: &Person) -> Course {
    course(person, vec![120.0; person.record.len()])
}

/// Why an effect cannot be an input of these records; `None` if it can.
pub(crate) fn cannot_be_input(effect: &dyn Effect, courses: &[Course]) -> Option<&'static str> {
    let driven = |course: &&Course| effect.form(course) == Some(Form::Driven);
    let Some(course) = courses.iter().find(driven) else {
        return Some("its events are hidden, or nobody's record signals it");
    };
    let at = |glucose: f64| {
        let course = Course { glucose: vec![glucose; course.len()], ..course.clone() };
        modulations(effect, 0, 1.0, &course)
    };
    (at(PROBES[0]) != at(PROBES[1])).then_some("it follows glucose, which an input must not know")
}

/// What an effect does in each step of a record; nothing where the record does not signal it.
pub(crate) fn modulations(
    effect: &dyn Effect,
    variant: usize,
    amplitude: f64,
    course: &Course,
) -> Vec<Modulation> {
    let mut steps = vec![Modulation::NEUTRAL; course.len()];
    if effect.form(course) == Some(Form::Driven) {
        effect.modulate(variant, amplitude, course, &mut steps);
    }
    steps
}

/// The population network of one person under modulations.
pub(crate) struct ModulatedNetwork<'a> {
    population: &'a PopulationModel,
    model: AugmentedModel,
}

impl<'a> ModulatedNetwork<'a> {
    pub(crate) fn new(population: &'a Arc<PopulationModel>, weight: Kilograms) -> Self {
        let body = Arc::new(NetworkBody(Arc::clone(population)));
        // The noise model belongs to the filter; nothing is filtered here.
        let noise = NoiseModel::working();
        let nominal = OdeParameters::nominal();
        let model = AugmentedModel::new(nominal, weight, EgpMode::NonNegative, noise);
        Self { population, model: model.with_body(body) }
    }

    /// What a window knows beforehand: states along the network's own free run under the modulations,
    /// and what these add to dQ1/dt beside what the network makes of the states.
    pub(crate) fn known(
        &self,
        start: &ScaledStates,
        inputs: &[StepInput],
        modulations: &[Modulation],
    ) -> Result<Known> {
        let mut known = Known { states: Vec::new(), beside: Vec::new() };
        let mut state = self.augmented(start);
        for (step, (input, modulation)) in inputs.iter().zip(modulations).enumerate() {
            let scaler = self.population.scaler();
            let now = scaler.scale(&self.model.report(&state));
            let following = self
                .model
                .step(&state, input, modulation)
                .with_context(|| format!("step {step} of a window under the effect"))?;
            let own = self.population.rate(Compartment::Q1, &now, scaler.scale_input(input));
            let after = scaler.scale(&self.model.report(&following));
            let glucose = self.model.report(&following)[Compartment::Q1];
            let moved = (after[Compartment::Q1] - now[Compartment::Q1]) / STEP.0;
            // At the end of its range glucose tells nothing of its rate; what acted before acts on.
            let beside = if confined(glucose) {
                known.beside.last().copied().unwrap_or(0.0)
            } else {
                moved - own
            };
            known.states.push(now);
            known.beside.push(beside);
            state = following;
        }
        Ok(known)
    }

    /// A scaled state as the filter's model has it.
    fn augmented(&self, start: &ScaledStates) -> AugmentedState {
        let scaler = self.population.scaler();
        let physical = scaler.unscale(start);
        let glucose = MgPerDl(physical[Compartment::Q1]);
        let mut x = OdeVector::default();
        for compartment in Compartment::ALL {
            x[compartment] = physical[compartment];
        }
        let v_g = self.model.plant().parameters.v_g;
        x[Compartment::Q1] = glucose.0 / MG_PER_DL_PER_MMOL_PER_L * v_g;
        let (template, _) = self.model.start(UnitsPerHour(0.0), glucose);
        AugmentedState { body: OdeState::default().with_vector(&x), ..template }
    }
}

fn confined(glucose: f64) -> bool {
    let (low, high) = (GLUCOSE_RANGE.0.0, GLUCOSE_RANGE.1.0);
    glucose <= low + 1e-9 || glucose >= high - 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::Field;
    use nn_statespace::initial_state::steady_state;
    use physiology::{Grams, OpenLoop, Units, simulate};
    use twins::{InputSet, PreparedWindow, ResidualNetwork, window_courses};

    fn inputs() -> Vec<StepInput> {
        (0..59)
            .map(|k| StepInput {
                basal: UnitsPerHour(1.0),
                bolus: Units(if k == 3 { 4.0 } else { 0.0 }),
                carbs: Grams(if k == 4 { 40.0 } else { 0.0 }),
                ..StepInput::default()
            })
            .collect()
    }

    fn course_under(modulations: &[Modulation]) -> Vec<f64> {
        let population = Arc::new(PopulationModel::shipped().expect("read"));
        let network = ModulatedNetwork::new(&population, Kilograms(76.3));
        let start = steady_state(&population, MgPerDl(130.0)).expect("found").states;
        let known = network.known(&start, &inputs(), modulations).expect("finite");
        let measured = vec![130.0; 60];
        let window =
            PreparedWindow::under(&population, inputs(), &measured, known, None, InputSet::None)
                .expect("fits");
        let courses = window_courses(&population, &ResidualNetwork::zeros(), &[window]);
        courses.expect("one").remove(0).into_iter().map(|g| g.0).collect()
    }

    #[test]
    fn nothing_acting_is_the_network_itself_and_an_effect_moves_it_as_in_the_filter() {
        let population = Arc::new(PopulationModel::shipped().expect("read"));
        let start = steady_state(&population, MgPerDl(130.0)).expect("found").states;
        let run = simulate(&*population, start, &mut OpenLoop::new(&inputs()), 59).expect("finite");
        let without = course_under(&[Modulation::NEUTRAL; 59]);
        for (state, found) in run.states.iter().zip(&without) {
            // States go through physical units and back.
            assert!((population.glucose(state).0 - found).abs() < 1e-6);
        }
        // Less insulin action from the twentieth step on, and a flux out of glucose.
        for (field, value, least) in [(Field::Action, 0.6, 3.0), (Field::Flux, -0.01, 10.0)] {
            let mut modulations = vec![Modulation::NEUTRAL; 59];
            for modulation in &mut modulations[20..] {
                modulation[field] = value;
            }
            let network = ModulatedNetwork::new(&population, Kilograms(76.3));
            let mut state = network.augmented(&start);
            let mut expected = vec![130.0];
            for (input, modulation) in inputs().iter().zip(&modulations) {
                state = network.model.step(&state, input, modulation).expect("finite");
                expected.push(network.model.report(&state)[Compartment::Q1]);
            }
            let found = course_under(&modulations);
            let moved = (found[59] - without[59]).abs();
            assert!(moved > least, "{field:?}: {moved}");
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found - expected).abs() < 1e-6, "{field:?}: {found} {expected}");
            }
        }
    }
}
