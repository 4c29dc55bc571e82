//! A window of a person's record, made ready for training.
//!
//! Only Q1 and Q2 depend on glucose: the insulin chain (S1, S2, I, X1, X2, X3) follows from insulin
//! and the gut (C1, C2) from carbohydrate. With the population model frozen, everything but Q1 and
//! Q2 is therefore the same in every epoch and is simulated once, here.

use nn_statespace::{PopulationModel, ScaledInputs, ScaledStates, Signal};
use physiology::{Compartment, OpenLoop, StepInput, simulate};

use crate::error::TwinError;
use crate::heart_rate::HeartRateScaler;
use crate::inputs::{INPUTS, InputSet, PERSONAL_INPUTS, STATE_INPUTS};

/// One window: its start, what acts on glucose in each step, and the glucose to be met.
#[derive(Debug, Clone, PartialEq)]
pub struct PreparedWindow {
    /// The population model's states at the start of each step, shape `(steps)`; Q1 and Q2 are
    /// meaningful in the first alone.
    states: Vec<ScaledStates>,
    /// Inputs of each step, shape `(steps)`.
    inputs: Vec<StepInput>,
    /// Insulin and carbohydrate of each step, scaled, shape `(steps)`.
    scaled: Vec<ScaledInputs>,
    /// Personal inputs of each step, shape `(steps, 5)`.
    pub(crate) personal: Vec<[f64; PERSONAL_INPUTS]>,
    /// Measured glucose in scaled units, shape `(steps + 1)`, the start first.
    target: Vec<f64>,
    /// What is added to dQ1/dt in each step beside population and residual network, scaled units
    /// per minute, shape `(steps)`.
    pub(crate) added_rates: Vec<f64>,
}

/// What of a window does not depend on its glucose, one entry a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// States at the start of each step, scaled; those of Q1 and Q2 count in the first alone.
    pub states: Vec<ScaledStates>,
    /// What is added to dQ1/dt, scaled units per minute.
    pub added_rates: Vec<f64>,
}

impl PreparedWindow {
    /// Simulates what does not depend on glucose from `start`.
    ///
    /// `inputs` has one entry a step and `glucose_mg_dl` one more: the start and the end of every
    /// step. The first glucose takes the place of the start's Q1.
    ///
    /// # Errors
    /// [`TwinError::Wiring`] if a compartment other than Q1 and Q2 sees glucose,
    /// [`TwinError::Window`] if the lengths do not fit, [`TwinError::NotFinite`] for a glucose that
    /// is not a finite number, and [`TwinError::Simulation`] if a state leaves the finite numbers.
    pub fn new(
        population: &PopulationModel,
        inputs: Vec<StepInput>,
        glucose_mg_dl: &[f64],
        start: ScaledStates,
        heart_rate: Option<&HeartRateScaler>,
        set: InputSet,
    ) -> Result<Self, TwinError> {
        check_wiring(population)?;
        let steps = inputs.len().saturating_sub(1);
        let states = simulate(population, start, &mut OpenLoop::new(&inputs), steps)?.states;
        let known = Known { states, added_rates: vec![0.0; inputs.len()] };
        Self::under(population, inputs, glucose_mg_dl, known, heart_rate, set)
    }

    /// The same where something else acts beside the population model and is known beforehand: an
    /// effect that is an input of the plant.
    ///
    /// # Errors
    /// As [`Self::new`]; [`TwinError::Window`] also if `known` has another length.
    pub fn under(
        population: &PopulationModel,
        inputs: Vec<StepInput>,
        glucose_mg_dl: &[f64],
        known: Known,
        heart_rate: Option<&HeartRateScaler>,
        set: InputSet,
    ) -> Result<Self, TwinError> {
        check_wiring(population)?;
        let Known { mut states, added_rates } = known;
        let steps = inputs.len();
        if steps == 0 || glucose_mg_dl.len() != steps + 1 {
            return Err(TwinError::Window { steps, glucose: glucose_mg_dl.len() });
        }
        if states.len() != steps || added_rates.len() != steps {
            return Err(TwinError::UnequalRuns {
                expected: steps,
                found: states.len().min(added_rates.len()),
            });
        }
        if added_rates.iter().any(|rate| !rate.is_finite()) {
            return Err(TwinError::NotFinite("what acts beside the population model"));
        }
        if glucose_mg_dl.iter().any(|value| !value.is_finite()) {
            return Err(TwinError::NotFinite("glucose of a training window"));
        }
        let scaled = glucose_mg_dl.iter().map(|value| scaled_glucose(population, *value));
        let target: Vec<f64> = scaled.collect();
        states[0][Compartment::Q1] = target[0];
        let personal =
            inputs.iter().map(|input| set.personal(&input.context, heart_rate)).collect();
        let scaled = inputs.iter().map(|input| population.scaler().scale_input(input)).collect();
        Ok(Self { states, inputs, scaled, personal, target, added_rates })
    }

    /// Steps of the window.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.inputs.len()
    }

    /// Inputs of each step.
    #[must_use]
    pub fn inputs(&self) -> &[StepInput] {
        &self.inputs
    }

    /// The state at the start of the window.
    #[must_use]
    pub fn start(&self) -> ScaledStates {
        self.states[0]
    }

    /// Measured glucose in scaled units, the start first.
    #[must_use]
    pub fn target(&self) -> &[f64] {
        &self.target
    }

    /// What is known of a step beforehand: the states but Q1 and Q2, and the inputs.
    pub(crate) fn known(&self, step: usize) -> (&ScaledStates, ScaledInputs) {
        (&self.states[step], self.scaled[step])
    }
}

/// The states among the residual network's inputs, in their order.
pub(crate) const SEEN: [Compartment; STATE_INPUTS] =
    [Compartment::Q1, Compartment::Q2, Compartment::X1, Compartment::X3, Compartment::C2];

/// Inputs of the residual network: the states of [`SEEN`], then the personal ones.
pub(crate) fn network_input(x: &ScaledStates, personal: &[f64; PERSONAL_INPUTS]) -> [f64; INPUTS] {
    let [q1, q2, x1, x3, c2] = SEEN.map(|compartment| x[compartment]);
    let [heart_rate, weekend, cos, sin, sleep] = *personal;
    [q1, q2, x1, x3, c2, heart_rate, weekend, cos, sin, sleep]
}

/// Glucose in mg/dL as scaled Q1.
pub(crate) fn scaled_glucose(population: &PopulationModel, mg_dl: f64) -> f64 {
    population.scaler().of(Signal::State(Compartment::Q1)).scale(mg_dl)
}

/// Q1 and Q2, whose steps depend on glucose.
pub(crate) const GLUCOSE: [Compartment; 2] = [Compartment::Q1, Compartment::Q2];

/// Checks that glucose reaches no compartment but Q1 and Q2.
fn check_wiring(population: &PopulationModel) -> Result<(), TwinError> {
    for compartment in Compartment::ALL.into_iter().filter(|c| !GLUCOSE.contains(c)) {
        for glucose in GLUCOSE {
            if population.wiring().inputs(compartment).contains(&Signal::State(glucose)) {
                return Err(TwinError::Wiring { compartment, glucose });
            }
        }
    }
    Ok(())
}
