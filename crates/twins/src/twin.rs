//! A digital twin: the population model and one person's addition to it.

use std::sync::Arc;

use cohort::Record;
use nn_statespace::{PerCompartment, PopulationModel, ScaledStates};
use physiology::{Compartment, MgPerDl, NonFinite, Plant, States, StepInput};

use crate::heart_rate::HeartRateScaler;
use crate::inputs::{INPUTS, InputSet};
use crate::prepared::{SEEN, network_input};
use crate::protocol::Protocol;
use crate::residual::ResidualNetwork;

/// Where a twin came from.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct TwinCard {
    /// The person the twin stands for.
    pub person_id: String,
    /// Where the weights came from, in words.
    pub origin: String,
    /// Version of the software that made the file.
    pub version: String,
    /// SHA-256 of the training windows, hexadecimal; `None` where they are not at hand.
    pub training_data_sha256: Option<String>,
    /// The resolved training configuration as JSON; `None` where it is not known.
    pub training: Option<serde_json::Value>,
}

/// One person's plant (paper, Eq. `indLevelNN`): the population model, with the output of the
/// person's residual network added to dQ1/dt inside the loop, before the clamp.
///
/// Personal inputs that a step lacks are read as [`InputSet::personal`] says;
/// [`MissingContext::count`](crate::MissingContext::count) tells how often that happens.
#[derive(Debug, Clone)]
pub struct Twin {
    /// The population model, frozen and shared between people.
    pub population: Arc<PopulationModel>,
    /// The person's network.
    pub residual: ResidualNetwork,
    /// Scaling of heart rate, from the person's training data; `None` if they held no heart rate.
    pub heart_rate_scaler: Option<HeartRateScaler>,
    /// Which personal inputs the network sees.
    pub inputs: InputSet,
    /// Where the twin came from.
    pub card: TwinCard,
}

impl Twin {
    /// What the residual network sees in a step, in the order of [`INPUT_NAMES`](crate::INPUT_NAMES).
    #[must_use]
    pub fn residual_inputs(&self, state: &ScaledStates, input: &StepInput) -> [f64; INPUTS] {
        let personal = self.inputs.personal(&input.context, self.heart_rate_scaler.as_ref());
        network_input(state, &personal)
    }

    /// The person's addition to dQ1/dt at a state, scaled units of Q1 per minute.
    #[must_use]
    pub fn residual_rate(&self, state: &ScaledStates, input: &StepInput) -> f64 {
        self.residual.evaluate(&self.residual_inputs(state, input))
    }

    /// [`residual_rate`](Self::residual_rate) with its slopes by the scaled states, per minute; 0 for
    /// states that the network does not see.
    #[must_use]
    pub fn residual_rate_and_slopes(
        &self,
        state: &ScaledStates,
        input: &StepInput,
    ) -> (f64, PerCompartment<f64>) {
        let seen = self.residual_inputs(state, input);
        let (rate, slopes) = self.residual.evaluate_with_slopes(&seen);
        let mut by_state = PerCompartment::from_fn(|_| 0.0);
        for (compartment, slope) in SEEN.into_iter().zip(slopes) {
            by_state[compartment] = slope;
        }
        (rate, by_state)
    }

    /// Whole days at the start of a record that trained the twin, `None` where its file does not say.
    ///
    /// `record` is the person's whole record; of a short one fewer days train
    /// ([`Protocol::training_days_of`]).
    #[must_use]
    pub fn training_days_of(&self, record: &Record) -> Option<usize> {
        let days = self.card.training.as_ref()?.get("training_days")?.as_u64()?;
        let training_days = usize::try_from(days).ok()?;
        Some(Protocol { training_days, ..Protocol::paper() }.training_days_of(record))
    }
}

impl Plant for Twin {
    type State = ScaledStates;

    fn step(&self, state: &ScaledStates, input: &StepInput) -> Result<ScaledStates, NonFinite> {
        let residual = self.residual_rate(state, input);
        if !residual.is_finite() {
            return Err(NonFinite { compartment: Compartment::Q1 });
        }
        self.population.step_with_residual(state, input, residual)
    }

    fn glucose(&self, state: &ScaledStates) -> MgPerDl {
        self.population.glucose(state)
    }

    fn report(&self, state: &ScaledStates) -> States {
        self.population.report(state)
    }
}
