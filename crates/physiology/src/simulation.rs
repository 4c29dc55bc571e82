//! The one simulation loop.

use crate::compartment::{Compartment, States};
use crate::input::StepInput;
use crate::plant::Plant;
use crate::units::MgPerDl;

/// Where the inputs of a simulation come from: a record, or something that reacts to glucose.
pub trait InputSource {
    /// The inputs of step `step`, decided when glucose at its start is `glucose`.
    ///
    /// `None` ends the simulation.
    fn next(&mut self, step: usize, glucose: MgPerDl) -> Option<StepInput>;
}

/// Inputs that were fixed beforehand, such as a recorded day.
#[derive(Debug, Clone)]
pub struct OpenLoop<'a> {
    inputs: &'a [StepInput],
}

impl<'a> OpenLoop<'a> {
    /// Feeds `inputs` in order and ends after the last.
    #[must_use]
    pub fn new(inputs: &'a [StepInput]) -> Self {
        Self { inputs }
    }
}

impl InputSource for OpenLoop<'_> {
    fn next(&mut self, step: usize, _: MgPerDl) -> Option<StepInput> {
        self.inputs.get(step).copied()
    }
}

/// The states and inputs of a simulation.
#[derive(Debug, Clone)]
pub struct Trajectory<S> {
    /// `inputs.len() + 1` states; `states[0]` is the start and `states[k + 1]` follows `inputs[k]`.
    pub states: Vec<S>,
    /// The inputs that acted, one a step.
    pub inputs: Vec<StepInput>,
}

impl<S: Clone> Trajectory<S> {
    /// Glucose of each state, the start included.
    pub fn glucose<P: Plant<State = S>>(&self, plant: &P) -> Vec<MgPerDl> {
        self.states.iter().map(|x| plant.glucose(x)).collect()
    }

    /// Each state in reporting units, the start included.
    pub fn report<P: Plant<State = S>>(&self, plant: &P) -> Vec<States> {
        self.states.iter().map(|x| plant.report(x)).collect()
    }
}

/// Why a simulation stopped early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SimulationError {
    /// A compartment left the finite numbers.
    #[error(
        "{compartment} is not a finite number after step {step}; check the weights, the initial \
         state and the doses of that step"
    )]
    NonFinite {
        /// The compartment at fault.
        compartment: Compartment,
        /// The step, counted from 0.
        step: usize,
    },
}

/// Runs `plant` from `initial` for at most `steps` steps.
///
/// The loop asks `source` for the inputs of a step, advances the plant, and keeps both. It ends
/// early when the source does.
///
/// # Errors
/// [`SimulationError::NonFinite`] with the compartment and the step.
pub fn simulate<P: Plant>(
    plant: &P,
    initial: P::State,
    source: &mut impl InputSource,
    steps: usize,
) -> Result<Trajectory<P::State>, SimulationError> {
    let mut states = Vec::with_capacity(steps + 1);
    let mut inputs = Vec::with_capacity(steps);
    states.push(initial);
    for step in 0..steps {
        let current = &states[step];
        let Some(input) = source.next(step, plant.glucose(current)) else {
            break;
        };
        let following = plant
            .step(current, &input)
            .map_err(|error| SimulationError::NonFinite { compartment: error.compartment, step })?;
        states.push(following);
        inputs.push(input);
    }
    Ok(Trajectory { states, inputs })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::NonFinite;
    use crate::units::Units;

    /// Adds each bolus to glucose and breaks at a negative one.
    struct Adding;

    impl Plant for Adding {
        type State = f64;

        fn step(&self, x: &f64, input: &StepInput) -> Result<f64, NonFinite> {
            if input.bolus.0 < 0.0 {
                return Err(NonFinite { compartment: Compartment::Q1 });
            }
            Ok(x + input.bolus.0)
        }

        fn glucose(&self, x: &f64) -> MgPerDl {
            MgPerDl(*x)
        }

        fn report(&self, x: &f64) -> States {
            let mut states = States::default();
            states[Compartment::Q1] = *x;
            states
        }
    }

    fn bolus(amount: f64) -> StepInput {
        StepInput { bolus: Units(amount), ..StepInput::default() }
    }

    #[test]
    fn the_start_is_kept_and_each_state_follows_its_input() {
        let inputs = [bolus(1.0), bolus(2.0)];
        let run = simulate(&Adding, 100.0, &mut OpenLoop::new(&inputs), 10).expect("finite");
        assert_eq!(run.states, vec![100.0, 101.0, 103.0]);
        assert_eq!(run.inputs.len(), 2);
    }

    #[test]
    fn a_source_sees_glucose_before_it_decides() {
        struct UntilAbove(f64);
        impl InputSource for UntilAbove {
            fn next(&mut self, _: usize, glucose: MgPerDl) -> Option<StepInput> {
                (glucose.0 <= self.0).then(|| bolus(5.0))
            }
        }
        let run = simulate(&Adding, 100.0, &mut UntilAbove(109.0), 100).expect("finite");
        assert_eq!(run.states, vec![100.0, 105.0, 110.0]);
    }

    #[test]
    fn an_error_names_compartment_and_step() {
        let inputs = [bolus(1.0), bolus(-1.0)];
        let error = simulate(&Adding, 100.0, &mut OpenLoop::new(&inputs), 2).expect_err("negative");
        assert_eq!(error, SimulationError::NonFinite { compartment: Compartment::Q1, step: 1 });
    }
}
