//! Where a window's simulation starts.
//!
//! The paper simulates, for training, all states but Q1 with the population model and takes Q1 from
//! the sensor ("Development dataset preprocessing"), and starts its evaluations from a steady state
//! ("Estimating initial states"). Both are here. A steady state forgets the insulin and the meal
//! that a person has on board when a window opens. Carried states keep them, but they also bring
//! every error of the plant's insulin sensitivity into the first minutes; on the two open data sets
//! that this was tried on, all methods err less from steady states.

use std::sync::{Arc, OnceLock};

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
    fn at_steady_state(&self, glucose: MgPerDl) -> Result<(Self::State, bool), TwinError>;
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

    fn at_steady_state(&self, glucose: MgPerDl) -> Result<(ScaledStates, bool), TwinError> {
        let found = steady_state(self, glucose)?;
        Ok((found.states, found.outcome == SteadyStateOutcome::Found))
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
    /// mg/dL for the population), nothing stands still: the state without any insulin is used, with
    /// the glucose asked for. It is what steady states come to as glucose rises towards the last that
    /// has one, so that a start depends on parameters without a jump.
    fn at_steady_state(&self, glucose: MgPerDl) -> Result<(OdeState, bool), TwinError> {
        let found = ode_sim::steady_state::state_at_glucose(&self.parameters, glucose);
        let (state, at_rest) = match found {
            Ok(state) => (state, true),
            Err(OdeError::NoBasal { .. }) => (OdeState::default(), false),
            Err(error) => return Err(error.into()),
        };
        Ok((self.with_glucose(&state, glucose), at_rest))
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
    let steady = SteadyStates::new(plant);
    window_starts_with(&steady, person, inputs, steps, start, mean_basal)
}

/// [`window_starts`] with steady states that are shared between people.
///
/// # Errors
/// As [`window_starts`].
pub fn window_starts_with<P: Startable>(
    steady: &SteadyStates<'_, P>,
    person: &Person,
    inputs: &[StepInput],
    steps: &[usize],
    start: WindowStart,
    mean_basal: UnitsPerHour,
) -> Result<Starts<P::State>, TwinError> {
    if start == WindowStart::Carried {
        let states = carried_starts(steady.plant, person, inputs, steps, mean_basal)?;
        return Ok(Starts { states, not_at_rest: 0 });
    }
    let mut starts = Starts { states: Vec::with_capacity(steps.len()), not_at_rest: 0 };
    for step in steps {
        let (state, at_rest) = steady.at(reading(person, *step)?)?;
        starts.states.push(state);
        starts.not_at_rest += usize::from(!at_rest);
    }
    Ok(starts)
}

/// A steady state, and whether the plant stays in it.
type Solved<S> = (S, bool);

/// The steady states of a plant, solved when first asked for, once for each mg/dL.
///
/// Sensors report whole mg/dL, so that a cohort's windows need far fewer solutions than there are
/// windows; a network's takes some 20 ms.
#[derive(Debug)]
pub struct SteadyStates<'a, P: Startable> {
    plant: &'a P,
    /// A place for each whole mg/dL.
    solved: Arc<[OnceLock<Solved<P::State>>]>,
}

/// Above this glucose, mg/dL, nothing is kept: no sensor reads that far.
const HIGHEST_KEPT: usize = 600;

impl<'a, P: Startable> SteadyStates<'a, P> {
    /// Nothing is solved yet.
    #[must_use]
    pub fn new(plant: &'a P) -> Self {
        Self { plant, solved: (0..=HIGHEST_KEPT).map(|_| OnceLock::new()).collect() }
    }

    /// The same states, found or yet to be found, for a plant that has them too and differs in how it
    /// moves between them: one with other gains on doses.
    #[must_use]
    pub fn of(&self, plant: &'a P) -> Self {
        Self { plant, solved: Arc::clone(&self.solved) }
    }

    /// The steady state at the glucose rounded to 1 mg/dL, with the glucose itself set.
    fn at(&self, glucose: MgPerDl) -> Result<(P::State, bool), TwinError> {
        let rounded = glucose.0.round().max(1.0);
        let place = self.solved.get(rounded as usize);
        let (state, at_rest) = match place.and_then(OnceLock::get) {
            Some(known) => known.clone(),
            None => {
                // Two threads may solve the same glucose at once; both find the same.
                let solved = self.plant.at_steady_state(MgPerDl(rounded))?;
                place.map_or_else(|| solved.clone(), |p| p.get_or_init(|| solved.clone()).clone())
            }
        };
        Ok((self.plant.with_glucose(&state, glucose), at_rest))
    }
}

/// The states that a run along the record reaches at each of `steps`.
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
        let doses = [record.basal(), record.bolus(), record.carbs()];
        let recorded = doses.iter().all(|channel| channel[step].is_some());
        let going_on = running.filter(|_| recorded);
        running = going_on.map(|state| advance(plant, &state, input, step)).transpose()?;
    }
    match wanted.next() {
        None => Ok(states),
        Some(step) => Err(TwinError::NoReading { person: person.id.clone(), step }),
    }
}

pub(crate) fn reading(person: &Person, step: usize) -> Result<MgPerDl, TwinError> {
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
