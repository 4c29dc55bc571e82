//! The roll-out of the population model as a plain candle graph.

use candle_core::backprop::GradStore;
use candle_core::{DType, Device, Tensor, Var};
use physiology::STEP;

use crate::error::ModelError;
use crate::network::{HiddenLayerNetwork, shaped};
use crate::per_compartment::PerCompartment;
use crate::training::windows::STATES;
use crate::wiring::Wiring;

/// Columns that the hidden layers see: ten states, insulin, carbohydrate, and the constant 1 that
/// carries the biases.
const COLUMNS: usize = STATES + 3;
const BIAS: usize = COLUMNS - 1;

/// All ten networks as two matrices, differentiable.
///
/// The hidden units of all networks stand side by side, so that a step is two matrix products
/// instead of twenty small ones: `w1` has shape (13, hidden) with the biases in its last row and
/// `w2` has shape (hidden, 10). Entries that the wiring does not know are held at zero by masks,
/// which the gradient passes through as well. Rows of states follow [`physiology::Compartment::ALL`].
#[derive(Debug)]
pub struct RollOut {
    wiring: Wiring,
    hidden: PerCompartment<usize>,
    w1: Var,
    w2: Var,
    b2: Var,
    mask1: Tensor,
    mask2: Tensor,
}

impl RollOut {
    /// The graph of these networks in the given precision (`F32` for training, `F64` for checks).
    ///
    /// # Errors
    /// [`ModelError::Shape`] if a network does not fit its wiring; [`ModelError::Tensor`] from
    /// candle.
    pub fn new(
        wiring: &Wiring,
        networks: &PerCompartment<HiddenLayerNetwork>,
        dtype: DType,
    ) -> Result<Self, ModelError> {
        let hidden = PerCompartment::from_fn(|c| networks[c].hidden());
        let total: usize = hidden.values().sum();
        let mut w1 = vec![0.0; COLUMNS * total];
        let mut mask1 = vec![0.0; COLUMNS * total];
        let mut w2 = vec![0.0; total * STATES];
        let mut mask2 = vec![0.0; total * STATES];
        let mut b2 = Vec::with_capacity(STATES);
        let mut first = 0;
        for (compartment, network) in networks.iter() {
            let signals = wiring.inputs(compartment);
            let expected = [network.hidden(), signals.len()];
            let found = [network.hidden(), network.inputs()];
            shaped(format_args!("{compartment}.hidden.weight"), &expected, &found)?;
            for unit in 0..network.hidden() {
                let column = first + unit;
                for (input, signal) in signals.iter().enumerate() {
                    let place = signal.row() * total + column;
                    w1[place] = network.w1()[unit * signals.len() + input];
                    mask1[place] = 1.0;
                }
                w1[BIAS * total + column] = network.b1()[unit];
                mask1[BIAS * total + column] = 1.0;
                w2[column * STATES + compartment as usize] = network.w2()[unit];
                mask2[column * STATES + compartment as usize] = 1.0;
            }
            b2.push(network.b2());
            first += network.hidden();
        }
        let tensor = |values: Vec<f64>, shape: (usize, usize)| {
            Tensor::from_vec(values, shape, &Device::Cpu)?.to_dtype(dtype)
        };
        Ok(Self {
            wiring: wiring.clone(),
            hidden,
            w1: Var::from_tensor(&tensor(w1, (COLUMNS, total))?)?,
            w2: Var::from_tensor(&tensor(w2, (total, STATES))?)?,
            b2: Var::from_tensor(&tensor(b2, (1, STATES))?)?,
            mask1: tensor(mask1, (COLUMNS, total))?,
            mask2: tensor(mask2, (total, STATES))?,
        })
    }

    /// What an optimiser may change.
    #[must_use]
    pub fn variables(&self) -> Vec<Var> {
        vec![self.w1.clone(), self.w2.clone(), self.b2.clone()]
    }

    /// The states after each step, shape (steps, batch, 10), without the start.
    ///
    /// `initial` has shape (batch, 10), `inputs` shape (steps, batch, 2) with insulin before
    /// carbohydrate; all scaled. Forward Euler, `x += 5 dx`, without a clamp.
    ///
    /// # Errors
    /// [`ModelError::Tensor`] if the shapes do not fit.
    pub fn simulate(&self, initial: &Tensor, inputs: &Tensor) -> Result<Tensor, ModelError> {
        let (steps, batch, _) = inputs.dims3()?;
        let w1 = (self.w1.as_tensor() * &self.mask1)?;
        // Minutes per step go into the output layer once instead of into every step.
        let w2 = ((self.w2.as_tensor() * &self.mask2)? * STEP.0)?;
        let b2 = (self.b2.as_tensor() * STEP.0)?;
        let ones = Tensor::ones((steps, batch, 1), inputs.dtype(), &Device::Cpu)?;
        let inputs = Tensor::cat(&[inputs, &ones], 2)?;
        let mut x = initial.clone();
        let mut states = Vec::with_capacity(steps);
        for step in 0..steps {
            let columns = Tensor::cat(&[&x, &inputs.get(step)?], 1)?;
            let hidden = columns.matmul(&w1)?.relu()?;
            x = (x + hidden.matmul(&w2)?.broadcast_add(&b2)?)?;
            states.push(x.clone());
        }
        Ok(Tensor::stack(&states, 0)?)
    }

    /// The networks with the present weights.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`] if training made a weight something else than a finite number.
    pub fn networks(&self) -> Result<PerCompartment<HiddenLayerNetwork>, ModelError> {
        self.arranged(&self.w1, &self.w2, &self.b2)
    }

    /// The slopes of a loss by the weights, each in the place of its weight.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`] if a slope is something else than a finite number;
    /// [`ModelError::Training`] if the loss does not depend on this graph.
    pub fn slopes(
        &self,
        gradients: &GradStore,
    ) -> Result<PerCompartment<HiddenLayerNetwork>, ModelError> {
        let of = |variable: &Var| {
            let problem = "the loss does not depend on the networks".to_owned();
            gradients.get(variable).ok_or(ModelError::Training(problem))
        };
        self.arranged(of(&self.w1)?, of(&self.w2)?, of(&self.b2)?)
    }

    /// Matrices in the shape of this graph's weights as networks.
    fn arranged(
        &self,
        w1: &Tensor,
        w2: &Tensor,
        b2: &Tensor,
    ) -> Result<PerCompartment<HiddenLayerNetwork>, ModelError> {
        let rows = |matrix: &Tensor| matrix.to_dtype(DType::F64)?.to_vec2::<f64>();
        let (w1, w2, b2) = (rows(w1)?, rows(w2)?, rows(b2)?);
        let mut first = 0;
        PerCompartment::try_from_fn(|compartment| {
            let signals = self.wiring.inputs(compartment);
            let units = first..first + self.hidden[compartment];
            first = units.end;
            HiddenLayerNetwork::new(
                signals.len(),
                units
                    .clone()
                    .flat_map(|unit| signals.iter().map(move |signal| (unit, signal.row())))
                    .map(|(unit, row)| w1[row][unit])
                    .collect(),
                units.clone().map(|unit| w1[BIAS][unit]).collect(),
                units.map(|unit| w2[unit][compartment as usize]).collect(),
                b2[0][compartment as usize],
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::initial_weights::initial_networks;
    use crate::widths::Widths;
    use physiology::Compartment;

    #[test]
    fn networks_survive_the_block_layout() {
        let wiring = Wiring::paper();
        let mut widths = PerCompartment::from_fn(|c| 3 + c as usize);
        widths[Compartment::Q2] = 1;
        let widths = Widths::new(widths).expect("positive");
        let networks = initial_networks(&wiring, &widths, 1.0, 3);
        for dtype in [DType::F32, DType::F64] {
            let graph = RollOut::new(&wiring, &networks, dtype).expect("fits");
            assert_eq!(graph.networks().expect("finite"), networks);
        }
    }
}
