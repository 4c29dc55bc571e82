//! The same loss in candle's graph: slower than the roll-out by hand, and its oracle.
//!
//! Shapes: `batch` windows side by side in rows; time runs over the operations of the graph.

use candle_core::{DType, Device, Tensor, Var};
use nn_statespace::{GlucoseClamp, PopulationModel, Signal};
use physiology::{Compartment, STEP};

use crate::error::TwinError;
use crate::inputs::INPUTS;
use crate::loss::{ScaledLoss, TwinLoss};
use crate::prepared::{PreparedWindow, network_input};
use crate::residual::{ResidualNetwork, SHAPES};

/// The residual network's parameters as candle variables, weights of shape `(inputs, outputs)`.
#[derive(Debug, Clone)]
pub struct ResidualVariables {
    /// Weight and bias of each layer, in turn.
    variables: Vec<Var>,
}

impl ResidualVariables {
    /// Variables with the values of `network`, f64 on the CPU.
    ///
    /// # Errors
    /// [`TwinError::Candle`].
    pub fn new(network: &ResidualNetwork) -> Result<Self, TwinError> {
        let mut variables = Vec::with_capacity(8);
        for (layer, shape) in network.layers().iter().zip(SHAPES) {
            let (weight, bias) = (layer.weight.as_slice(), layer.bias.as_slice());
            variables.push(Var::from_slice(weight, shape, &Device::Cpu)?);
            variables.push(Var::from_slice(bias, (1, shape.1), &Device::Cpu)?);
        }
        Ok(Self { variables })
    }

    /// The eight variables: weight and bias of each layer, in turn.
    #[must_use]
    pub fn variables(&self) -> &[Var] {
        &self.variables
    }

    /// The network with the variables' present values.
    ///
    /// # Errors
    /// [`TwinError::Candle`].
    pub fn network(&self) -> Result<ResidualNetwork, TwinError> {
        let mut network = ResidualNetwork::zeros();
        for (layer, pair) in network.layers_mut().iter_mut().zip(self.variables.chunks_exact(2)) {
            layer.weight = pair[0].as_tensor().flatten_all()?.to_vec1()?;
            layer.bias = pair[1].as_tensor().flatten_all()?.to_vec1()?;
        }
        Ok(network)
    }

    fn forward(&self, input: &Tensor) -> Result<Tensor, TwinError> {
        let mut x = input.clone();
        for (i, pair) in self.variables.chunks_exact(2).enumerate() {
            x = x.matmul(&pair[0])?.broadcast_add(&pair[1])?;
            if i < 3 {
                x = x.relu()?;
            }
        }
        Ok(x)
    }
}

/// Mean loss of a batch of windows as a scalar tensor whose graph reaches the variables.
///
/// Glucose flows through the frozen population networks of Q1 and Q2, so that a gradient crosses
/// all steps of a window.
///
/// # Errors
/// [`TwinError::NoWindows`], [`TwinError::UnequalWindows`] and [`TwinError::Candle`].
pub fn graph_loss(
    population: &PopulationModel,
    variables: &ResidualVariables,
    windows: &[&PreparedWindow],
    loss: TwinLoss,
) -> Result<Tensor, TwinError> {
    let scaled = loss.scaled_by(population);
    let first = windows.first().ok_or(TwinError::NoWindows)?;
    let steps = first.steps();
    if let Some(other) = windows.iter().find(|w| w.steps() != steps) {
        return Err(TwinError::UnequalWindows { first: steps, other: other.steps() });
    }
    let column = |value: &dyn Fn(&PreparedWindow) -> f64| -> Result<Tensor, TwinError> {
        let values: Vec<f64> = windows.iter().map(|w| value(w)).collect();
        Ok(Tensor::from_vec(values, (windows.len(), 1), &Device::Cpu)?)
    };
    let mut q1 = column(&|w| w.start()[Compartment::Q1])?;
    let mut q2 = column(&|w| w.start()[Compartment::Q2])?;
    let mut error = q1.zeros_like()?;
    let mut sum = Tensor::zeros((), DType::F64, &Device::Cpu)?;
    for step in 0..steps {
        let known = known_inputs(windows, step)?;
        let residual = variables.forward(&Tensor::cat(&[&q1, &q2, &known], 1)?)?;
        let rate_1 = rate(population, Compartment::Q1, windows, step, &q1, &q2)?;
        let rate_2 = rate(population, Compartment::Q2, windows, step, &q1, &q2)?;
        let added_rate = column(&|w| w.added_rate(step))?;
        q1 = clamp(population, &(q1 + (((rate_1 + residual)? + added_rate)? * STEP.0)?)?)?;
        q2 = (q2 + (rate_2 * STEP.0)?)?;
        let measured = column(&|w| w.target()[step + 1])?;
        let following = (&q1 - &measured)?;
        let penalty = penalties(&scaled, &q1, windows, step)?;
        let fit = (following.sqr()? * penalty)?.sum_all()?;
        let change = (&following - &error)?.sqr()?.sum_all()?;
        sum = ((sum + fit)? + (change * scaled.consistency())?)?;
        error = following;
    }
    Ok((sum / (steps * windows.len()) as f64)?)
}

/// Inputs of the residual network after Q1 and Q2, shape `(batch, 8)`.
fn known_inputs(windows: &[&PreparedWindow], step: usize) -> Result<Tensor, TwinError> {
    let mut values = Vec::with_capacity(windows.len() * (INPUTS - 2));
    for window in windows {
        let x = window.states_with(step, 0.0, 0.0);
        values.extend_from_slice(&network_input(&x, window.personal(step))[2..]);
    }
    Ok(Tensor::from_vec(values, (windows.len(), INPUTS - 2), &Device::Cpu)?)
}

/// The frozen rate of a compartment, shape `(batch, 1)`.
fn rate(
    population: &PopulationModel,
    compartment: Compartment,
    windows: &[&PreparedWindow],
    step: usize,
    q1: &Tensor,
    q2: &Tensor,
) -> Result<Tensor, TwinError> {
    let mut columns = Vec::new();
    for signal in population.wiring().inputs(compartment) {
        columns.push(match signal {
            Signal::State(Compartment::Q1) => q1.clone(),
            Signal::State(Compartment::Q2) => q2.clone(),
            known => {
                let values: Vec<f64> = windows
                    .iter()
                    .map(|w| {
                        let u = population.scaler().scale_input(&w.inputs()[step]);
                        match known {
                            Signal::State(state) => w.states_with(step, 0.0, 0.0)[*state],
                            Signal::Insulin => u.insulin,
                            Signal::Carbs => u.carbs,
                        }
                    })
                    .collect();
                Tensor::from_vec(values, (windows.len(), 1), &Device::Cpu)?
            }
        });
    }
    let network = population.network(compartment);
    let (hidden, inputs) = (network.hidden(), network.inputs());
    let w1 = Tensor::from_slice(network.w1(), (hidden, inputs), &Device::Cpu)?;
    let b1 = Tensor::from_slice(network.b1(), (1, hidden), &Device::Cpu)?;
    let w2 = Tensor::from_slice(network.w2(), (hidden, 1), &Device::Cpu)?;
    let activation = Tensor::cat(&columns, 1)?.matmul(&w1.t()?)?.broadcast_add(&b1)?.relu()?;
    Ok((activation.matmul(&w2)? + network.b2())?)
}

fn clamp(population: &PopulationModel, q1: &Tensor) -> Result<Tensor, TwinError> {
    Ok(match population.clamp() {
        GlucoseClamp::Reproduction => {
            let (lowest, highest) = population.scaled_glucose_range();
            q1.clamp(lowest, highest)?
        }
        GlucoseClamp::Off => q1.clone(),
    })
}

/// Penalties at the present values, constants of the graph, shape `(batch, 1)`.
fn penalties(
    loss: &ScaledLoss,
    q1: &Tensor,
    windows: &[&PreparedWindow],
    step: usize,
) -> Result<Tensor, TwinError> {
    let simulated: Vec<f64> = q1.detach().flatten_all()?.to_vec1()?;
    let values: Vec<f64> = simulated
        .iter()
        .zip(windows)
        .map(|(q1, window)| loss.penalty(*q1, window.target()[step + 1]))
        .collect();
    Ok(Tensor::from_vec(values, (windows.len(), 1), &Device::Cpu)?)
}
