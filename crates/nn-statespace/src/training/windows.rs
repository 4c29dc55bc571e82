//! Simulated runs as they come, and the scaler of a few of them.

use physiology::{Compartment, States, StepInput};

use crate::error::ModelError;
use crate::scaler::{CentreAndScale, Scaler};
use crate::signal::Signal;

/// States a row holds.
pub(crate) const STATES: usize = 10;
/// Inputs a row holds: insulin, carbohydrate.
pub(crate) const INPUTS: usize = 2;
/// Signals that networks can see.
pub(crate) const SIGNALS: usize = STATES + INPUTS;

/// One simulated run in physical units: `states[k + 1]` follows `states[k]` under `inputs[k]`.
#[derive(Debug, Clone, Copy)]
pub struct Run<'a> {
    /// One more than there are inputs.
    pub states: &'a [States],
    /// What acted during each step.
    pub inputs: &'a [StepInput],
}

impl Run<'_> {
    /// Its states row by row, and insulin (basal and bolus together) and carbohydrate of each step;
    /// `index` names the run in errors.
    pub(crate) fn rows(&self, index: usize) -> Result<(Vec<f64>, Vec<f64>), ModelError> {
        if self.states.len() != self.inputs.len() + 1 {
            let problem = "there must be one more state than inputs";
            return Err(ModelError::Windows { run: index, problem });
        }
        let states = self.states.iter().flat_map(|x| x.iter().map(|(_, value)| value));
        let inputs =
            self.inputs.iter().flat_map(|u| [u.insulin().0, (u.carbs + u.rescue.amount).0]);
        Ok((states.collect(), inputs.collect()))
    }
}

/// The value of the latent compartment C1 at the start of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CarbStart {
    /// What the run reports, so that a window may start during a meal. C1 still has no error term.
    Reported,
    /// Nothing, as where the source knows no such compartment.
    Zero,
}

impl Scaler {
    /// Fits the scaler to training runs: median and interquartile range of every state over all
    /// rows and of both inputs over all steps; C1, which has no ground truth, keeps centre 0 and
    /// scale 1 (paper, appendix on the robust scaler).
    ///
    /// # Errors
    /// [`ModelError::NoRows`] without rows, [`ModelError::NotFinite`] with the signal at fault.
    pub fn fit(runs: &[Run<'_>]) -> Result<Self, ModelError> {
        let inputs = || runs.iter().flat_map(|run| run.inputs);
        Self::try_from_fn(|signal| {
            let values: Vec<f64> = match signal {
                Signal::State(Compartment::C1) => {
                    return Ok(CentreAndScale { centre: 0.0, scale: 1.0 });
                }
                Signal::State(state) => {
                    runs.iter().flat_map(|run| run.states).map(|x| x[state]).collect()
                }
                Signal::Insulin => inputs().map(|u| u.insulin().0).collect(),
                Signal::Carbs => inputs().map(|u| (u.carbs + u.rescue.amount).0).collect(),
            };
            CentreAndScale::robust(signal, values)
        })
    }
}
