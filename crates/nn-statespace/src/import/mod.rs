//! Reader of the weights and scalers that the paper's authors published.
//!
//! Their repository holds the population model as a PyTorch state dictionary, its two scalers as
//! pickled scikit-learn objects, and for each person an individual network with the scaler of its
//! heart rate. All of them are read from bytes, without Python and without executing anything;
//! every shape is checked, and anything unexpected is an error that names the tensor or the
//! offset. candle has a reader of its own for such files, which works on paths, panics on some
//! damaged ones and does not know the pickles of scikit-learn; it serves as a second opinion in
//! the tests.

mod archive;
mod pickle;
mod robust_scaler;
mod state_dict;

use physiology::Compartment;
use state_dict::StateDict;

use crate::error::ModelError;
use crate::network::{HiddenLayerNetwork, finite, shaped};
use crate::per_compartment::PerCompartment;
use crate::population::{GlucoseClamp, ModelCard, PopulationModel};
use crate::scaler::{CentreAndScale, Scaler};
use crate::wiring::Wiring;

/// Order of the states in the authors' weights, scalers and published traces.
pub const FILE_ORDER: [Compartment; 10] = [
    Compartment::Q1,
    Compartment::Q2,
    Compartment::S1,
    Compartment::S2,
    Compartment::I,
    Compartment::X1,
    Compartment::X2,
    Compartment::X3,
    Compartment::C2,
    Compartment::C1,
];

/// Inputs of the individual network: Q1, Q2, X1, X3, C2 (scaled), heart rate over baseline
/// (scaled by its own scaler), weekend, cos and sin of the hour, sleep efficiency.
pub const INDIVIDUAL_INPUTS: usize = 10;

/// A fully connected layer: `y = weight x + bias`.
#[derive(Debug, Clone, PartialEq)]
pub struct DenseLayer {
    /// Length of x.
    pub inputs: usize,
    /// Length of y.
    pub outputs: usize,
    /// Row-major, shape (outputs, inputs).
    pub weight: Vec<f64>,
    /// Shape (outputs).
    pub bias: Vec<f64>,
}

/// The population model from its state dictionary (`population_model_*.pt`) and the pickled
/// scalers of its states (`scaler_states.pkl`) and inputs (`scaler_inputs.pkl`).
///
/// The clamp of Q1 is on, as in the authors' code. Weights and centres are promoted from f32.
///
/// # Errors
/// [`ModelError`] with the tensor, entry or offset at fault.
pub fn population(
    weights: &[u8],
    scaler_states: &[u8],
    scaler_inputs: &[u8],
) -> Result<PopulationModel, ModelError> {
    let wiring = Wiring::paper();
    let mut dictionary = StateDict::read(weights)?;
    let networks = PerCompartment::try_from_fn(|compartment| {
        let inputs = wiring.inputs(compartment).len();
        let tensor = |part: &str| format!("net_d{compartment}.{part}");
        let b1 = dictionary.take(&tensor("0.bias"))?;
        let hidden = b1.values.len();
        shaped(b1.name, &[hidden], &b1.shape)?;
        let w1 = dictionary.take_shaped(&tensor("0.weight"), &[hidden, inputs])?;
        let w2 = dictionary.take_shaped(&tensor("2.weight"), &[1, hidden])?;
        let b2 = dictionary.take_shaped(&tensor("2.bias"), &[1])?;
        HiddenLayerNetwork::new(inputs, w1, b1.values, w2, b2[0])
    })?;
    dictionary.finish()?;
    let scaler = scaler(scaler_states, scaler_inputs)?;
    let card = ModelCard {
        origin: "imported from a published PyTorch state dictionary".to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        training_data_sha256: None,
        training: None,
    };
    PopulationModel::new(wiring, networks, scaler, GlucoseClamp::Reproduction, card)
}

/// The scaler from the pickled scalers of the states and of the inputs.
///
/// # Errors
/// [`ModelError`] with the array or offset at fault.
pub fn scaler(scaler_states: &[u8], scaler_inputs: &[u8]) -> Result<Scaler, ModelError> {
    let states = robust_scaler::read(scaler_states, FILE_ORDER.len())?;
    let inputs = robust_scaler::read(scaler_inputs, 2)?;
    let mut by_name = PerCompartment::from_fn(|_| CentreAndScale { centre: 0.0, scale: 1.0 });
    for (compartment, pair) in FILE_ORDER.into_iter().zip(states) {
        by_name[compartment] = pair;
    }
    Scaler::new(by_name, inputs[0], inputs[1])
}

/// The layers of an individual network (`individual_model.pt`), first to last; a rectified linear
/// unit follows each but the last.
///
/// # Errors
/// [`ModelError`] with the tensor, entry or offset at fault; a network that does not take
/// [`INDIVIDUAL_INPUTS`] inputs or does not end in one output is refused.
pub fn individual_network(weights: &[u8]) -> Result<[DenseLayer; 4], ModelError> {
    let mut dictionary = StateDict::read(weights)?;
    let mut inputs = INDIVIDUAL_INPUTS;
    let mut layer = |position: usize| -> Result<DenseLayer, ModelError> {
        let bias = dictionary.take(&format!("net_model.{position}.bias"))?;
        let outputs = if position == 6 { 1 } else { bias.values.len() };
        shaped(bias.name, &[outputs.max(1)], &bias.shape)?;
        let name = format!("net_model.{position}.weight");
        let weight = dictionary.take_shaped(&name, &[outputs, inputs])?;
        let inputs = std::mem::replace(&mut inputs, outputs);
        Ok(DenseLayer { inputs, outputs, weight, bias: bias.values })
    };
    // nn.Sequential counts the rectifiers too.
    let layers = [layer(0)?, layer(2)?, layer(4)?, layer(6)?];
    dictionary.finish()?;
    Ok(layers)
}

/// Centre and scale of a person's heart rate over baseline, 1/min (`scaler_robust.pkl`).
///
/// # Errors
/// [`ModelError`] with the array or offset at fault, or a scale that is not positive.
pub fn heart_rate_scaler(pickle: &[u8]) -> Result<CentreAndScale, ModelError> {
    let pair = robust_scaler::read(pickle, 1)?[0];
    if pair.scale <= 0.0 {
        let problem = "a scale must be positive";
        return Err(ModelError::BadTensor { tensor: "scale_".to_owned(), problem });
    }
    Ok(pair)
}

/// The little-endian numbers of 4 or of 8 bytes in a tensor's content.
pub(crate) fn floats(tensor: &str, content: &[u8], width: usize) -> Result<Vec<f64>, ModelError> {
    let values: Vec<f64> = if width == 4 {
        let chunks = content.as_chunks::<4>().0.iter();
        chunks.map(|four| f64::from(f32::from_le_bytes(*four))).collect()
    } else {
        content.as_chunks::<8>().0.iter().map(|eight| f64::from_le_bytes(*eight)).collect()
    };
    finite(tensor, &values)?;
    Ok(values)
}
