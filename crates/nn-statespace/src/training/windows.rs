//! Simulated runs as they come, and the scaler of a few of them.

use physiology::{Compartment, States, StepInput};

use crate::error::ModelError;
use crate::per_compartment::PerCompartment;
use crate::scaler::{CentreAndScale, Scaler};
use crate::signal::Signal;

/// States a row holds.
pub(crate) const STATES: usize = 10;
/// Inputs a row holds: insulin, carbohydrate.
pub(crate) const INPUTS: usize = 2;

/// One simulated run in physical units: `states[k + 1]` follows `states[k]` under `inputs[k]`.
#[derive(Debug, Clone, Copy)]
pub struct Run<'a> {
    /// One more than there are inputs.
    pub states: &'a [States],
    /// What acted during each step.
    pub inputs: &'a [StepInput],
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
        let states = PerCompartment::try_from_fn(|compartment| {
            if compartment == Compartment::C1 {
                return Ok(CentreAndScale { centre: 0.0, scale: 1.0 });
            }
            let values = runs.iter().flat_map(|run| run.states.iter().map(|x| x[compartment]));
            CentreAndScale::robust(Signal::State(compartment), values.collect())
        })?;
        let insulin = runs.iter().flat_map(|run| run.inputs.iter().map(|u| u.insulin().0));
        let carbs =
            runs.iter().flat_map(|run| run.inputs.iter().map(|u| (u.carbs + u.rescue.amount).0));
        Self::new(
            states,
            CentreAndScale::robust(Signal::Insulin, insulin.collect())?,
            CentreAndScale::robust(Signal::Carbs, carbs.collect())?,
        )
    }
}
