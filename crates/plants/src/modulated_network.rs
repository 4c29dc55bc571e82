//! An effect as an input of the population network: what its modulations do to a window before any
//! residual network has a say.

use std::sync::Arc;

use cohort::{Person, Window};
use effects::{Course, Effect, Form, Modulation};
use gap::filter::augmented::AugmentedModel;
use gap::filter::state::AugmentedState;
use gap::{ModulatedPlant, ModulatedState, NoiseModel, course};
use nn_statespace::{GLUCOSE_RANGE, PopulationModel, ScaledStates};
use ode_sim::{OdeParameters, OdeState, OdeVector};
use physiology::{
    Compartment, Kilograms, MgPerDl, OpenLoop, STEP, StepInput, UnitsPerHour, simulate,
};
use twins::Known;

use crate::bodies::NetworkBody;
use crate::error::PlantsError;

/// Glucose at which drivers are compared to see whether they follow it, mg/dL.
const PROBES: [f64; 2] = [60.0, 240.0];
/// Change of a free run between two passes below which it counts as found, mg/dL.
const SETTLED: f64 = 0.5;
/// Most passes; each knows glucose a little further into the window than the one before.
const PASSES: usize = 12;

/// An effect with the variant by which it acts in everybody who has an amplitude of it.
#[derive(Debug)]
pub struct Acting {
    /// The effect.
    pub effect: Box<dyn Effect>,
    /// Index of its variant.
    pub variant: usize,
}

/// The course of a person's record from which drivers are made, with the last reading where one is
/// missing. Inside a window [`Active::known`] replaces them: what an input knows of readings ahead of a
/// window's start, a simulation must not.
pub fn course_of(person: &Person) -> Course {
    let readings = person.record.cgm();
    let mut last = readings.iter().copied().flatten().next().unwrap_or(120.0);
    let glucose = readings
        .iter()
        .map(|reading| {
            last = reading.unwrap_or(last);
            last
        })
        .collect();
    course(person, glucose)
}

/// Why an effect cannot be an input of these records; `None` if it can.
pub fn cannot_be_input(effect: &dyn Effect, courses: &[Course]) -> Option<&'static str> {
    let driven = |course: &Course| effect.form(course) == Some(Form::Driven);
    let signalled = courses.iter().any(driven);
    (!signalled).then_some("its events are hidden, or nobody's record signals it")
}

/// What acts in one person: with glucose known ahead or not.
#[derive(Debug)]
pub struct Active<'a> {
    course: &'a Course,
    /// What does not look at glucose, over the whole record.
    fixed: Vec<Modulation>,
    /// What follows glucose, with its variant and amplitude.
    following: Vec<(&'a dyn Effect, usize, f64)>,
}

impl<'a> Active<'a> {
    /// Effects with variants and amplitudes; those that the record does not signal, or with an amplitude
    /// of 0, do nothing.
    pub fn new(
        course: &'a Course,
        effects: impl IntoIterator<Item = (&'a dyn Effect, usize, f64)>,
    ) -> Self {
        let mut fixed = vec![Modulation::NEUTRAL; course.len()];
        let mut following = Vec::new();
        for (effect, variant, amplitude) in effects {
            if effect.form(course) != Some(Form::Driven) || amplitude <= 0.0 {
                continue;
            }
            if follows_glucose(effect, course) {
                following.push((effect, variant, amplitude));
            } else {
                effect.modulate(variant, amplitude, course, &mut fixed);
            }
        }
        Self { course, fixed, following }
    }

    /// What a window knows beforehand. What follows glucose follows the readings up to the window's start
    /// and from there the network's own free run under the effects, found by passes: drivers do not look
    /// ahead, so that each pass makes more of it right.
    pub fn known(
        &self,
        network: &ModulatedNetwork<'_>,
        start: &ScaledStates,
        window: &Window,
        inputs: &[StepInput],
    ) -> Result<Known, PlantsError> {
        let steps = window.start..window.start + inputs.len();
        let mut known = network.known(start, inputs, &self.fixed[steps.clone()])?;
        if self.following.is_empty() {
            return Ok(known);
        }
        let mut course = self.course.clone();
        for _ in 0..PASSES {
            let mut moved = 0.0_f64;
            for (glucose, states) in course.glucose[steps.clone()].iter_mut().zip(&known.states) {
                let found = network.glucose(states);
                moved = moved.max((found - *glucose).abs());
                *glucose = found;
            }
            if moved < SETTLED {
                break;
            }
            let mut modulations = self.fixed.clone();
            for (effect, variant, amplitude) in &self.following {
                effect.modulate(*variant, *amplitude, &course, &mut modulations);
            }
            known = network.known(start, inputs, &modulations[steps.clone()])?;
        }
        Ok(known)
    }
}

fn follows_glucose(effect: &dyn Effect, course: &Course) -> bool {
    let at = |glucose: f64| {
        let course = Course { glucose: vec![glucose; course.len()], ..course.clone() };
        let mut steps = vec![Modulation::NEUTRAL; course.len()];
        effect.modulate(0, 1.0, &course, &mut steps);
        steps
    };
    at(PROBES[0]) != at(PROBES[1])
}

/// The population network of one person under modulations.
pub struct ModulatedNetwork<'a> {
    population: &'a PopulationModel,
    model: AugmentedModel,
}

impl<'a> ModulatedNetwork<'a> {
    /// The network of a person of this weight.
    #[must_use]
    pub fn new(population: &'a Arc<PopulationModel>, weight: Kilograms) -> Self {
        let body = Arc::new(NetworkBody(Arc::clone(population)));
        // The noise model belongs to the filter; nothing is filtered here.
        let noise = NoiseModel::working();
        let nominal = OdeParameters::nominal();
        let model = AugmentedModel::new(nominal, weight, noise);
        Self { population, model: model.with_body(body) }
    }

    /// What a window knows beforehand: states along the network's own free run under the modulations,
    /// and what these add to dQ1/dt beside what the network makes of the states.
    pub fn known(
        &self,
        start: &ScaledStates,
        inputs: &[StepInput],
        modulations: &[Modulation],
    ) -> Result<Known, PlantsError> {
        let plant = ModulatedPlant::new(&self.model, modulations);
        let start = ModulatedState { step: 0, state: self.augmented(start) };
        let steps = inputs.len().min(modulations.len());
        let run = simulate(&plant, start, &mut OpenLoop::new(inputs), steps)?;
        let scaler = self.population.scaler();
        let reported = run.report(&plant);
        let mut known = Known { states: Vec::new(), added_rates: Vec::new() };
        for (input, states) in run.inputs.iter().zip(reported.windows(2)) {
            let [now, after] = [&states[0], &states[1]].map(|states| scaler.scale(states));
            let own = self.population.rate(Compartment::Q1, &now, scaler.scale_input(input));
            let glucose = states[1][Compartment::Q1];
            let moved = (after[Compartment::Q1] - now[Compartment::Q1]) / STEP.0;
            // At the end of its range glucose tells nothing of its rate; what acted before acts on.
            let added_rate = if confined(glucose) {
                known.added_rates.last().copied().unwrap_or(0.0)
            } else {
                moved - own
            };
            known.states.push(now);
            known.added_rates.push(added_rate);
        }
        Ok(known)
    }

    /// Glucose of a scaled state, mg/dL.
    fn glucose(&self, states: &ScaledStates) -> f64 {
        self.population.scaler().unscale(states)[Compartment::Q1]
    }

    /// A scaled state as the filter's model has it.
    fn augmented(&self, start: &ScaledStates) -> AugmentedState {
        let physical = self.population.scaler().unscale(start);
        let glucose = MgPerDl(physical[Compartment::Q1]);
        let mut x = OdeVector(Compartment::ALL.map(|compartment| physical[compartment]));
        x[Compartment::Q1] = self.model.person().q1_at(glucose);
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
    use effects::{Field, find};
    use nn_statespace::initial_state::steady_state;
    use physiology::{Grams, Plant as _, Units};
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

    #[test]
    fn an_effect_that_follows_glucose_sees_readings_before_a_window_and_the_run_within() {
        let population = Arc::new(PopulationModel::shipped().expect("read"));
        let network = ModulatedNetwork::new(&population, Kilograms(76.3));
        let start = steady_state(&population, MgPerDl(130.0)).expect("found").states;
        let exercise = find("exercise").expect("in the library");
        // An hour of exercise from the twentieth step of a window that begins at step 288.
        let n = 400;
        let mut rates = vec![Some(2.0); n];
        rates[308..320].fill(Some(60.0));
        let course = |ahead: f64| Course {
            hour: (0..n).map(|k| k as f64 / 12.0 % 24.0).collect(),
            day: (0..n).map(|k| k / 288).collect(),
            weekend: vec![false; n],
            carbs: vec![0.0; n],
            bolus: vec![0.0; n],
            heart_rate_over_rest: Some(rates.clone()),
            glucose: (0..n).map(|k| if k <= 288 { 130.0 } else { ahead }).collect(),
            ..Course::default()
        };
        let window = Window { person: 0, start: 288, len: 60 };
        let run = |course: &Course, amplitude: f64| {
            let active = Active::new(course, [(&*exercise, 0, amplitude)]);
            let known = active.known(&network, &start, &window, &inputs()).expect("finite");
            known.states.iter().map(|states| network.glucose(states)).collect::<Vec<f64>>()
        };
        assert!(follows_glucose(&*exercise, &course(130.0)));
        let (none, once, twice) =
            (run(&course(130.0), 0.0), run(&course(130.0), 1.0), run(&course(130.0), 2.0));
        assert!((none[20] - once[20]).abs() < 1e-9, "nothing before the bout");
        // beta x 60 of glucose a minute for an hour: 3.4e-4 x 60 x 60 x about 150, less what flows back.
        let fall = none[32] - once[32];
        assert!((60.0..200.0).contains(&fall), "{fall}");
        // In proportion to what is left, twice the effect takes less than twice as much.
        let fall_twice = none[32] - twice[32];
        assert!(fall_twice > 1.1 * fall && fall_twice < 1.95 * fall, "{fall} {fall_twice}");
        // Readings ahead of the start tell nothing.
        let other = run(&course(350.0), 1.0);
        for (one, other) in once.iter().zip(&other) {
            assert!((one - other).abs() < SETTLED, "{one} {other}");
        }
    }
}
