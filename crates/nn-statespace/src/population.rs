//! The population model: ten networks, their wiring and scaler, as a plant.

use physiology::{Compartment, MgPerDl, NonFinite, Plant, STEP, States, StepInput};
use serde::{Deserialize, Serialize};

use crate::error::ModelError;
use crate::network::{HiddenLayerNetwork, shaped};
use crate::per_compartment::PerCompartment;
use crate::scaler::{DoseGains, ScaledInputs, ScaledStates, Scaler};
use crate::signal::Signal;
use crate::widths::Widths;
use crate::wiring::Wiring;

/// Range of a continuous glucose monitor, to which the authors' code confines Q1, mg/dL.
pub const GLUCOSE_RANGE: (MgPerDl, MgPerDl) = (MgPerDl(40.0), MgPerDl(400.0));

/// More inputs than this no network can have: ten states, insulin and carbohydrate.
const MOST_INPUTS: usize = 12;

/// Whether Q1 is confined after each step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GlucoseClamp {
    /// Q1 is confined to [`GLUCOSE_RANGE`] after every step, as in the authors' published code
    /// (the paper does not mention it). Needed to reproduce their figures.
    Reproduction,
    /// Q1 runs free.
    Off,
}

/// Provenance of a model, kept in its weight file.
///
/// Everything that follows from the weights themselves (widths, wiring, state order) is written
/// from the model and is not repeated here.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModelCard {
    /// Where the weights came from, in words: "trained on ...", "imported from ...".
    pub origin: String,
    /// Version of the software that made them.
    pub version: String,
    /// SHA-256 of the training data in hexadecimal; `None` where the data are not at hand, as for
    /// published weights.
    pub training_data_sha256: Option<String>,
    /// The resolved training configuration as JSON; `None` where it is not known.
    pub training: Option<serde_json::Value>,
}

/// The population-level model of paper Eq. 2, a plant over scaled states.
///
/// A step is Forward Euler in scaled space, `x += 5 dx` with `dx` in scaled units per minute,
/// followed by the clamp of Q1 if that is on.
#[derive(Debug, Clone, PartialEq)]
pub struct PopulationModel {
    wiring: Wiring,
    networks: PerCompartment<HiddenLayerNetwork>,
    scaler: Scaler,
    clamp: GlucoseClamp,
    card: ModelCard,
}

impl PopulationModel {
    /// A model from its parts; each network's inputs are those that `wiring` names, in its order.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if a network does not have as many inputs as its wiring.
    pub fn new(
        wiring: Wiring,
        networks: PerCompartment<HiddenLayerNetwork>,
        scaler: Scaler,
        clamp: GlucoseClamp,
        card: ModelCard,
    ) -> Result<Self, ModelError> {
        for (compartment, network) in networks.iter() {
            let expected = [network.hidden(), wiring.inputs(compartment).len()];
            let found = [network.hidden(), network.inputs()];
            shaped(format_args!("{compartment}.hidden.weight"), &expected, &found)?;
        }
        Ok(Self { wiring, networks, scaler, clamp, card })
    }

    /// The same model with Q1 confined or free.
    #[must_use]
    pub fn with_clamp(self, clamp: GlucoseClamp) -> Self {
        Self { clamp, ..self }
    }

    /// The same networks in a body that answers to doses with gains of its own. Its steady states at a
    /// glucose are the population's; files of the model do not hold the gains.
    ///
    /// # Errors
    /// [`ModelError::DoseGain`] if a gain is not a positive finite number.
    pub fn with_dose_gains(self, gains: DoseGains) -> Result<Self, ModelError> {
        Ok(Self { scaler: self.scaler.with_dose_gains(gains)?, ..self })
    }

    /// The network of one compartment.
    #[must_use]
    pub fn network(&self, compartment: Compartment) -> &HiddenLayerNetwork {
        &self.networks[compartment]
    }

    /// Which signals each network sees.
    #[must_use]
    pub fn wiring(&self) -> &Wiring {
        &self.wiring
    }

    /// The scaler the model was trained with.
    #[must_use]
    pub fn scaler(&self) -> &Scaler {
        &self.scaler
    }

    /// Whether Q1 is confined after each step.
    #[must_use]
    pub fn clamp(&self) -> GlucoseClamp {
        self.clamp
    }

    /// Where the weights came from.
    #[must_use]
    pub fn card(&self) -> &ModelCard {
        &self.card
    }

    /// Hidden units of each network.
    #[must_use]
    pub fn widths(&self) -> Widths {
        Widths::new(PerCompartment::from_fn(|c| self.networks[c].hidden()))
            .expect("a network with no hidden unit cannot be built")
    }

    /// The rates of all states, scaled units per minute (paper Eq. 2).
    #[must_use]
    pub fn derivative(&self, x: &ScaledStates, u: ScaledInputs) -> PerCompartment<f64> {
        PerCompartment::from_fn(|compartment| self.rate(compartment, x, u))
    }

    /// The rate of one state, scaled units per minute.
    #[must_use]
    pub fn rate(&self, compartment: Compartment, x: &ScaledStates, u: ScaledInputs) -> f64 {
        let network = &self.networks[compartment];
        network.evaluate(&self.gathered(compartment, x, u)[..network.inputs()])
    }

    /// What the network of a compartment sees, scaled, in the order of its wiring.
    #[must_use]
    pub fn seen_by(&self, compartment: Compartment, x: &ScaledStates, u: ScaledInputs) -> Vec<f64> {
        self.gathered(compartment, x, u)[..self.wiring.inputs(compartment).len()].to_vec()
    }

    /// The same at the front of more places than any network needs; does not allocate.
    fn gathered(
        &self,
        compartment: Compartment,
        x: &ScaledStates,
        u: ScaledInputs,
    ) -> [f64; MOST_INPUTS] {
        let mut gathered = [0.0; MOST_INPUTS];
        for (slot, signal) in gathered.iter_mut().zip(self.wiring.inputs(compartment)) {
            *slot = match signal {
                Signal::State(state) => x[*state],
                Signal::Insulin => u.insulin,
                Signal::Carbs => u.carbs,
            };
        }
        gathered
    }

    /// The rate of one state and its slopes by the states, per minute; 0 for states that its network does
    /// not see. Units of networks exactly at their kink count as inactive.
    #[must_use]
    pub fn rate_and_slopes(
        &self,
        compartment: Compartment,
        x: &ScaledStates,
        u: ScaledInputs,
    ) -> (f64, PerCompartment<f64>) {
        let network = &self.networks[compartment];
        let (gathered, mut slopes) = (self.gathered(compartment, x, u), [0.0; MOST_INPUTS]);
        let (seen, slopes) = (&gathered[..network.inputs()], &mut slopes[..network.inputs()]);
        network.add_gradient(seen, 1.0, slopes);
        let mut by_state = PerCompartment::from_fn(|_| 0.0);
        for (signal, slope) in self.wiring.inputs(compartment).iter().zip(slopes) {
            if let Signal::State(state) = signal {
                by_state[*state] = *slope;
            }
        }
        (network.evaluate(seen), by_state)
    }

    /// A step in which `residual`, in scaled units of Q1 per minute, is added to the rate of Q1
    /// before the clamp: the place of the individual-level network (paper Eq. for y_Ind).
    ///
    /// # Errors
    /// If a compartment leaves the finite numbers.
    pub fn step_with_residual(
        &self,
        state: &ScaledStates,
        input: &StepInput,
        residual: f64,
    ) -> Result<ScaledStates, NonFinite> {
        let mut rates = self.derivative(state, self.scaler.scale_input(input));
        rates[Compartment::Q1] += residual;
        let mut next = *state;
        for (compartment, rate) in rates.iter() {
            next[compartment] += STEP.0 * rate;
            if !next[compartment].is_finite() {
                return Err(NonFinite { compartment });
            }
        }
        if self.clamp == GlucoseClamp::Reproduction {
            let (lowest, highest) = self.scaled_glucose_range();
            // The state was checked to be finite, so that clamp cannot hide a NaN.
            next[Compartment::Q1] = next[Compartment::Q1].clamp(lowest, highest);
        }
        Ok(next)
    }

    /// [`GLUCOSE_RANGE`] in scaled units of Q1.
    #[must_use]
    pub fn scaled_glucose_range(&self) -> (f64, f64) {
        scaled_glucose_range(&self.scaler)
    }
}

impl Plant for PopulationModel {
    type State = ScaledStates;

    fn step(&self, state: &ScaledStates, input: &StepInput) -> Result<ScaledStates, NonFinite> {
        self.step_with_residual(state, input, 0.0)
    }

    fn glucose(&self, state: &ScaledStates) -> MgPerDl {
        MgPerDl(self.scaler.unscale(state)[Compartment::Q1])
    }

    fn report(&self, state: &ScaledStates) -> States {
        self.scaler.unscale(state)
    }
}

/// [`GLUCOSE_RANGE`] in scaled units of Q1.
pub(crate) fn scaled_glucose_range(scaler: &Scaler) -> (f64, f64) {
    let glucose = scaler.of(Signal::State(Compartment::Q1));
    (glucose.scale(GLUCOSE_RANGE.0.0), glucose.scale(GLUCOSE_RANGE.1.0))
}
