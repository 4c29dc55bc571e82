//! Many runs of one twin at once.

use nn_statespace::kernel::{LANES, LaneSteps, Signals};
use nn_statespace::{ScaledInputs, ScaledStates, Signal};
use physiology::{Compartment, MgPerDl, STEP, SimulationError, StepInput};
use rayon::prelude::*;

use super::residual_lanes::{Activations, evaluate, parameters_of};
use crate::error::TwinError;
use crate::inputs::STATE_INPUTS;
use crate::prepared::SEEN;
use crate::twin::Twin;

/// Free runs of a twin from many starts: glucose before the first and after every step, mg/dL, shape
/// `(runs, steps + 1)`.
///
/// The same as [`physiology::simulate`] run by run, in single precision and some hundred times
/// faster: runs are lanes of vectors, blocks of them go to different threads. Rounding makes a
/// difference of some hundredths of a mg/dL over a day. Does not depend on the number of threads.
///
/// # Errors
/// [`TwinError::UnequalRuns`] if there are not as many lists of inputs as starts, all of one length;
/// [`TwinError::Simulation`] if a state leaves the finite numbers.
pub fn simulate_many(
    twin: &Twin,
    starts: &[ScaledStates],
    inputs: &[&[StepInput]],
) -> Result<Vec<Vec<MgPerDl>>, TwinError> {
    let steps = inputs.first().map_or(0, |inputs| inputs.len());
    if let Some(other) = inputs.iter().find(|inputs| inputs.len() != steps) {
        return Err(TwinError::UnequalRuns { expected: steps, found: other.len() });
    }
    if inputs.len() != starts.len() {
        return Err(TwinError::UnequalRuns { expected: starts.len(), found: inputs.len() });
    }
    let parameters: Vec<f32> = parameters_of(&twin.residual);
    let lane_steps = LaneSteps::<f32>::new(&twin.population, &Compartment::ALL)?;
    let blocks: Result<Vec<Vec<Vec<MgPerDl>>>, TwinError> = starts
        .par_chunks(LANES)
        .zip(inputs.par_chunks(LANES))
        .map(|(starts, inputs)| block(twin, &parameters, lane_steps.clone(), starts, inputs))
        .collect();
    Ok(blocks?.into_iter().flatten().collect())
}

/// The runs of one block of lanes.
fn block(
    twin: &Twin,
    parameters: &[f32],
    mut lane_steps: LaneSteps<f32>,
    starts: &[ScaledStates],
    inputs: &[&[StepInput]],
) -> Result<Vec<Vec<MgPerDl>>, TwinError> {
    let glucose = twin.population.scaler().of(Signal::State(Compartment::Q1));
    let mut now: Signals<f32> = [[0.0; LANES]; 12];
    for compartment in Compartment::ALL {
        for (lane, value) in now[compartment as usize].iter_mut().enumerate() {
            // Idle lanes repeat the first run.
            *value = starts.get(lane).unwrap_or(&starts[0])[compartment] as f32;
        }
    }
    let mut next = now;
    let mut activations = Activations::<f32>::new();
    let steps = inputs[0].len();
    let mut found = vec![Vec::with_capacity(steps + 1); starts.len()];
    let keep = |now: &Signals<f32>, found: &mut [Vec<MgPerDl>]| {
        for (run, scaled) in found.iter_mut().zip(now[Compartment::Q1 as usize]) {
            run.push(MgPerDl(glucose.unscale(f64::from(scaled))));
        }
    };
    keep(&now, &mut found);
    for step in 0..steps {
        for lane in 0..LANES {
            let input = &inputs.get(lane).unwrap_or(&inputs[0])[step];
            load(twin, input, lane, &mut now, &mut activations);
        }
        for (row, compartment) in activations.input.iter_mut().zip(SEEN) {
            *row = now[compartment as usize];
        }
        let residual = evaluate(parameters, &mut activations);
        lane_steps.step_without_slopes(&now, &mut next);
        for (q1, residual) in next[Compartment::Q1 as usize].iter_mut().zip(residual) {
            *q1 += STEP.0 as f32 * residual;
        }
        lane_steps.confine_glucose(&mut next);
        std::mem::swap(&mut now, &mut next);
        for compartment in Compartment::ALL {
            let values = &now[compartment as usize][..starts.len()];
            if values.iter().any(|value| !value.is_finite()) {
                return Err(SimulationError::NonFinite { compartment, step }.into());
            }
        }
        keep(&now, &mut found);
    }
    Ok(found)
}

/// Writes what a step's input brings into a lane.
fn load(
    twin: &Twin,
    input: &StepInput,
    lane: usize,
    now: &mut Signals<f32>,
    activations: &mut Activations<f32>,
) {
    let ScaledInputs { insulin, carbs } = twin.population.scaler().scale_input(input);
    now[Signal::Insulin.row()][lane] = insulin as f32;
    now[Signal::Carbs.row()][lane] = carbs as f32;
    let personal = twin.inputs.personal(&input.context, twin.heart_rate_scaler.as_ref());
    for (row, value) in activations.input[STATE_INPUTS..].iter_mut().zip(personal) {
        row[lane] = value as f32;
    }
}
