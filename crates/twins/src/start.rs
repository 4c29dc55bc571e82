//! Where a window's simulation starts.
//!
//! The paper simulates, for training, all states but Q1 with the population model and takes Q1 from
//! the sensor ("Development dataset preprocessing"), and starts its evaluations from a steady state
//! ("Estimating initial states"). Both are here. A steady state forgets the insulin and the meal
//! that a person has on board when a window opens; [`WindowStart::Carried`] does not.

use cohort::Person;
use nn_statespace::initial_state::{SteadyStateOutcome, steady_state};
use nn_statespace::{PopulationModel, ScaledStates};
use ode_sim::{OdeError, OdePlant, OdeState};
use physiology::{Compartment, MgPerDl, Plant, STEPS_PER_DAY, StepInput, UnitsPerHour};

use crate::error::TwinError;
use crate::prepared::scaled_glucose;

/// How the states at the start of a window are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WindowStart {
    /// The plant's steady state at the window's first sensor reading.
    SteadyState,
    /// The states that the plant reaches when it is run along the record from its beginning with
    /// each sensor reading put in the place of glucose.
    ///
    /// A run begins, and begins anew after a step whose doses are not recorded, at the first
    /// reading, with the states settled for a day at that glucose and the person's mean basal rate.
    Carried,
}

/// A plant whose glucose can be set, which both kinds of start need.
pub trait Startable: Plant {
    /// The same state with another glucose.
    fn with_glucose(&self, state: &Self::State, glucose: MgPerDl) -> Self::State;

    /// Any finite state, from which a settling run begins.
    fn neutral(&self) -> Self::State;

    /// The plant's steady state at a glucose, without carbohydrate, and whether it is one: a
    /// network need not have any, and then this is where it moves least.
    ///
    /// # Errors
    /// Those of the plant's solver.
    fn at_steady_state(&self, glucose: MgPerDl) -> Result<(Self::State, AtRest), TwinError>;
}

/// Whether a start is a steady state that a body could have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AtRest {
    /// It is.
    Yes,
    /// The solver found none within physical range; the state with the smallest rates is used.
    Nearly,
}

impl Startable for PopulationModel {
    fn with_glucose(&self, state: &ScaledStates, glucose: MgPerDl) -> ScaledStates {
        let mut set = *state;
        set[Compartment::Q1] = scaled_glucose(self, glucose.0);
        set
    }

    fn neutral(&self) -> ScaledStates {
        ScaledStates::default()
    }

    fn at_steady_state(&self, glucose: MgPerDl) -> Result<(ScaledStates, AtRest), TwinError> {
        let found = steady_state(self, glucose)?;
        let rest = match found.outcome {
            SteadyStateOutcome::Found => AtRest::Yes,
            _ => AtRest::Nearly,
        };
        Ok((found.states, rest))
    }
}

impl Startable for OdePlant {
    fn with_glucose(&self, state: &OdeState, glucose: MgPerDl) -> OdeState {
        OdeState { q1: self.q1_at(glucose), ..*state }
    }

    fn neutral(&self) -> OdeState {
        OdeState::default()
    }

    /// Where the kidneys clear more glucose than the liver makes even without insulin (above 400
    /// mg/dL for the population), nothing stands still: the steady state at the next lower
    /// multiple of 10 mg/dL that has one is used, with the glucose asked for.
    fn at_steady_state(&self, glucose: MgPerDl) -> Result<(OdeState, AtRest), TwinError> {
        let solve = |at| ode_sim::steady_state::at_glucose(&self.parameters, self.weight, at);
        let mut tens = (glucose.0 / 10.0).ceil() - 1.0;
        let mut rest = AtRest::Yes;
        let mut found = solve(glucose);
        while matches!(found, Err(OdeError::NoBasal { .. })) && tens > 0.0 {
            found = solve(MgPerDl(10.0 * tens));
            tens -= 1.0;
            rest = AtRest::Nearly;
        }
        Ok((self.with_glucose(&found?.state, glucose), rest))
    }
}

/// The state of a plant that was held at a glucose for a day under a constant basal rate and
/// nothing else.
///
/// # Errors
/// [`TwinError::Simulation`] if a state leaves the finite numbers.
pub fn settled<P: Startable>(
    plant: &P,
    glucose: MgPerDl,
    basal: UnitsPerHour,
) -> Result<P::State, TwinError> {
    let input = StepInput { basal, ..StepInput::default() };
    let mut state = plant.with_glucose(&plant.neutral(), glucose);
    for step in 0..STEPS_PER_DAY {
        state = plant.with_glucose(&advance(plant, &state, &input, step)?, glucose);
    }
    Ok(state)
}

/// The starts of some steps of a person's record, in the order asked for.
#[derive(Debug, Clone)]
pub struct Starts<S> {
    /// One state a step.
    pub states: Vec<S>,
    /// How many of them (or of the beginnings of the runs they come from) are no steady state
    /// although [`WindowStart::SteadyState`] asked for one.
    pub not_at_rest: usize,
}

/// The states at the start of each of `steps`, ascending, each of which must have a sensor reading.
///
/// `inputs` are those of the whole record, doses that are not recorded as zero; `mean_basal` is
/// where [`WindowStart::Carried`] settles.
///
/// # Errors
/// [`TwinError::NoReading`] for a step without a reading, those of the plant and of its solver.
pub fn window_starts<P: Startable>(
    plant: &P,
    person: &Person,
    inputs: &[StepInput],
    steps: &[usize],
    start: WindowStart,
    mean_basal: UnitsPerHour,
) -> Result<Starts<P::State>, TwinError> {
    match start {
        WindowStart::SteadyState => steady_starts(plant, person, steps),
        WindowStart::Carried => {
            let states = carried_starts(plant, person, inputs, steps, mean_basal)?;
            Ok(Starts { states, not_at_rest: 0 })
        }
    }
}

fn steady_starts<P: Startable>(
    plant: &P,
    person: &Person,
    steps: &[usize],
) -> Result<Starts<P::State>, TwinError> {
    // Sensors report whole mg/dL, so that a person's windows need far fewer solutions than there
    // are windows.
    let mut solved: Vec<(f64, P::State, AtRest)> = Vec::new();
    let mut starts = Starts { states: Vec::with_capacity(steps.len()), not_at_rest: 0 };
    for step in steps {
        let glucose = reading(person, *step)?;
        let position = match solved.iter().position(|(g, _, _)| *g == glucose.0.round()) {
            Some(position) => position,
            None => {
                let rounded = glucose.0.round();
                let (state, rest) = plant.at_steady_state(MgPerDl(rounded))?;
                solved.push((rounded, state, rest));
                solved.len() - 1
            }
        };
        let (_, state, rest) = &solved[position];
        starts.states.push(plant.with_glucose(state, glucose));
        starts.not_at_rest += usize::from(*rest == AtRest::Nearly);
    }
    Ok(starts)
}

fn carried_starts<P: Startable>(
    plant: &P,
    person: &Person,
    inputs: &[StepInput],
    steps: &[usize],
    mean_basal: UnitsPerHour,
) -> Result<Vec<P::State>, TwinError> {
    let record = &person.record;
    let mut states = Vec::with_capacity(steps.len());
    let mut wanted = steps.iter().copied().peekable();
    let mut running: Option<P::State> = None;
    for (step, input) in inputs.iter().enumerate() {
        let measured = record.cgm()[step].map(MgPerDl);
        running = match (running, measured) {
            (Some(state), Some(glucose)) => Some(plant.with_glucose(&state, glucose)),
            (None, Some(glucose)) => Some(settled(plant, glucose, mean_basal)?),
            (state, None) => state,
        };
        while wanted.next_if_eq(&step).is_some() {
            reading(person, step)?;
            states.push(running.clone().expect("a reading starts a run"));
        }
        if wanted.peek().is_none() {
            break;
        }
        let recorded = [record.basal(), record.bolus(), record.carbs()]
            .into_iter()
            .all(|channel| channel[step].is_some());
        running = match running {
            Some(state) if recorded => Some(advance(plant, &state, input, step)?),
            _ => None,
        };
    }
    match wanted.next() {
        None => Ok(states),
        Some(step) => Err(TwinError::NoReading { person: person.id.clone(), step }),
    }
}

fn reading(person: &Person, step: usize) -> Result<MgPerDl, TwinError> {
    match person.record.cgm().get(step) {
        Some(Some(glucose)) if glucose.is_finite() => Ok(MgPerDl(*glucose)),
        _ => Err(TwinError::NoReading { person: person.id.clone(), step }),
    }
}

fn advance<P: Plant>(
    plant: &P,
    state: &P::State,
    input: &StepInput,
    step: usize,
) -> Result<P::State, TwinError> {
    plant.step(state, input).map_err(|error| {
        physiology::SimulationError::NonFinite { compartment: error.compartment, step }.into()
    })
}
