//! How far a start is from standing still, and the meal that it amounts to.

use physiology::{
    Compartment, Grams, OpenLoop, STEP, STEPS_PER_DAY, SimulationError, StepInput, simulate,
};

use crate::initial_state::SteadyState;
use crate::{PopulationModel, ScaledInputs, ScaledStates, Signal};

/// A meal that calibrates the latent compartment.
const TEST_MEAL: Grams = Grams(6.0);

/// What a start amounts to beside the model's own steady state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartCheck {
    /// Largest rate of change at the best constant basal rate, scaled units per minute.
    pub residual: f64,
    /// The latent compartment C1, scaled.
    pub c1: f64,
    /// Meal that would put as much glucose into the blood over a day as the excess of C1 does.
    pub phantom_carbs: Grams,
}

/// Compares `start` with the model's steady state `own` at the same glucose.
///
/// # Errors
/// A run that leaves the finite numbers.
pub fn check_start(
    model: &PopulationModel,
    own: &SteadyState,
    start: ScaledStates,
) -> Result<StartCheck, SimulationError> {
    // A table states no basal rate; it is judged at the rate that suits it best. Only S1 depends
    // on the rate, so that the other nine rates bound the residual from below.
    let carbs = model.scaler().scale_carbs(Grams(0.0));
    let insulin = model.scaler().scale_insulin(own.basal);
    let rates = model.derivative(&start, ScaledInputs { insulin, carbs });
    let residual = Compartment::ALL
        .into_iter()
        .filter(|c| !model.wiring().inputs(*c).contains(&Signal::Insulin))
        .map(|c| rates[c].abs())
        .fold(0.0, f64::max);

    let mut their_gut = own.states;
    their_gut[Compartment::C1] = start[Compartment::C1];
    let with_their_gut = appeared(model, own, their_gut, Grams(0.0))?;
    let at_rest = appeared(model, own, own.states, Grams(0.0))?;
    let meal = appeared(model, own, own.states, TEST_MEAL)? - at_rest;
    let phantom_carbs = Grams(TEST_MEAL.0 * (with_their_gut - at_rest) / meal);
    Ok(StartCheck { residual, c1: start[Compartment::C1], phantom_carbs })
}

/// Meal glucose that appears over a day from a start, with `carbs` in the first step, mmol/kg.
fn appeared(
    model: &PopulationModel,
    own: &SteadyState,
    start: ScaledStates,
    carbs: Grams,
) -> Result<f64, SimulationError> {
    let mut inputs = vec![StepInput { basal: own.basal, ..StepInput::default() }; STEPS_PER_DAY];
    inputs[0].carbs = carbs;
    let run = simulate(model, start, &mut OpenLoop::new(&inputs), STEPS_PER_DAY)?;
    Ok(run.report(model).iter().map(|states| states[Compartment::C2] * STEP.0).sum())
}
