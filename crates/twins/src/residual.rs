//! The residual network of one person, evaluated in f64.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::error::TwinError;
use crate::inputs::INPUTS;

/// Widths of the hidden layers (paper, "Individual-level model").
pub const HIDDEN: [usize; 3] = [128, 64, 32];
/// Weights and biases of 10-128-64-32-1.
pub const PARAMETERS: usize = (INPUTS + 1) * HIDDEN[0]
    + (HIDDEN[0] + 1) * HIDDEN[1]
    + (HIDDEN[1] + 1) * HIDDEN[2]
    + HIDDEN[2]
    + 1;

/// One fully connected layer, `output = W^T input + b`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Layer {
    /// Weights, shape `(inputs, outputs)`, row-major: the transpose of the published layout.
    pub(crate) weight: Vec<f64>,
    /// Biases, one an output.
    pub(crate) bias: Vec<f64>,
}

impl Layer {
    fn zeros(inputs: usize, outputs: usize) -> Self {
        Self { weight: vec![0.0; inputs * outputs], bias: vec![0.0; outputs] }
    }

    /// Slopes by the inputs from those by the outputs. `rectified` holds the inputs where they are outputs of
    /// a ReLU, whose cut units pass nothing on.
    fn pull_back<const N: usize>(&self, by_output: &[f64], rectified: Option<&[f64]>) -> [f64; N] {
        let mut by_input = [0.0; N];
        let rows = self.weight.chunks_exact(by_output.len());
        for (unit, (slope, row)) in by_input.iter_mut().zip(rows).enumerate() {
            if rectified.is_none_or(|values| values[unit] > 0.0) {
                *slope = row.iter().zip(by_output).map(|(w, by)| w * by).sum();
            }
        }
        by_input
    }

    /// The outputs after a ReLU, which keeps a NaN.
    fn rectified<const N: usize>(&self, input: &[f64]) -> [f64; N] {
        let mut output = [0.0; N];
        self.apply(input, &mut output);
        for value in &mut output {
            if *value < 0.0 {
                *value = 0.0;
            }
        }
        output
    }

    /// Adds the contribution of each non-zero input to `output`, which starts as the bias. After
    /// a ReLU about half of the inputs are zero, and skipping them is exact.
    fn apply(&self, input: &[f64], output: &mut [f64]) {
        output.copy_from_slice(&self.bias);
        for (x, row) in input.iter().zip(self.weight.chunks_exact(output.len())) {
            if *x != 0.0 {
                for (y, w) in output.iter_mut().zip(row) {
                    *y += w * x;
                }
            }
        }
    }
}

/// N_Ind of the paper (Eq. `indLevelNNComp`): ten inputs, hidden layers of 128, 64 and 32 with
/// ReLU, one output. The output is a person's addition to dQ1/dt in scaled units per minute.
///
/// Inputs in order: Q1, Q2, X1, X3, C2 (scaled), then [`InputSet::personal`].
///
/// [`InputSet::personal`]: crate::InputSet::personal
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualNetwork {
    pub(crate) layers: [Layer; 4],
}

/// Shapes `(inputs, outputs)` of the four layers.
pub(crate) const SHAPES: [(usize, usize); 4] =
    [(INPUTS, HIDDEN[0]), (HIDDEN[0], HIDDEN[1]), (HIDDEN[1], HIDDEN[2]), (HIDDEN[2], 1)];

impl ResidualNetwork {
    /// The network that adds nothing: a twin with it equals the population model.
    #[must_use]
    pub fn zeros() -> Self {
        Self { layers: SHAPES.map(|(inputs, outputs)| Layer::zeros(inputs, outputs)) }
    }

    /// Hidden weights and biases uniform in +-1/sqrt(inputs), the default of the library that the
    /// authors used; the last layer zero, so that the untrained twin equals the population model.
    #[must_use]
    pub fn untrained(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut network = Self::zeros();
        for (layer, (inputs, _)) in network.layers.iter_mut().zip(SHAPES).take(3) {
            let bound = 1.0 / (inputs as f64).sqrt();
            for value in layer.weight.iter_mut().chain(&mut layer.bias) {
                *value = rng.random_range(-bound..bound);
            }
        }
        network
    }

    /// Adds a constant to what the network answers, scaled units of Q1 per minute.
    pub(crate) fn add_to_output(&mut self, rate: f64) {
        self.layers[3].bias[0] += rate;
    }

    /// A network from its four weight matrices, each of shape `(outputs, inputs)` row-major as in
    /// the published files, and its four bias vectors.
    ///
    /// # Errors
    /// [`TwinError::Shape`] or [`TwinError::NotFiniteWeight`], naming the tensor.
    pub fn from_tensors(weights: [&[f64]; 4], biases: [&[f64]; 4]) -> Result<Self, TwinError> {
        let mut network = Self::zeros();
        for (i, (inputs, outputs)) in SHAPES.into_iter().enumerate() {
            let (weight, bias) = (weights[i], biases[i]);
            for (kind, found, expected) in
                [("weight", weight.len(), inputs * outputs), ("bias", bias.len(), outputs)]
            {
                if found != expected {
                    return Err(TwinError::Shape { tensor: tensor_name(i, kind), found, expected });
                }
            }
            for (kind, values) in [("weight", weight), ("bias", bias)] {
                if values.iter().any(|v| !v.is_finite()) {
                    return Err(TwinError::NotFiniteWeight(tensor_name(i, kind)));
                }
            }
            let weight = transposed(weight, outputs, inputs);
            network.layers[i] = Layer { weight, bias: bias.to_vec() };
        }
        Ok(network)
    }

    /// Weights (shape `(outputs, inputs)`, row-major) and biases of the four layers, the first one first.
    #[must_use]
    pub fn matrices(&self) -> [(Vec<f64>, Vec<f64>); 4] {
        std::array::from_fn(|i| {
            let Layer { weight, bias } = &self.layers[i];
            (transposed(weight, SHAPES[i].0, SHAPES[i].1), bias.clone())
        })
    }

    /// A person's addition to dQ1/dt, scaled units per minute. Allocates nothing.
    #[must_use]
    pub fn evaluate(&self, input: &[f64; INPUTS]) -> f64 {
        self.forward(input).3
    }

    /// The output and its slopes by the inputs. Units exactly at their kink count as inactive.
    #[must_use]
    pub fn evaluate_with_slopes(&self, input: &[f64; INPUTS]) -> (f64, [f64; INPUTS]) {
        let (first, second, third, output) = self.forward(input);
        let by_third: [f64; HIDDEN[2]] = self.layers[3].pull_back(&[1.0], Some(&third));
        let by_second: [f64; HIDDEN[1]] = self.layers[2].pull_back(&by_third, Some(&second));
        let by_first: [f64; HIDDEN[0]] = self.layers[1].pull_back(&by_second, Some(&first));
        (output, self.layers[0].pull_back(&by_first, None))
    }

    /// What each hidden layer puts out after its ReLU, and the output.
    fn forward(
        &self,
        input: &[f64; INPUTS],
    ) -> ([f64; HIDDEN[0]], [f64; HIDDEN[1]], [f64; HIDDEN[2]], f64) {
        let first: [f64; HIDDEN[0]] = self.layers[0].rectified(input);
        let second: [f64; HIDDEN[1]] = self.layers[1].rectified(&first);
        let third: [f64; HIDDEN[2]] = self.layers[2].rectified(&second);
        let mut output = [0.0];
        self.layers[3].apply(&third, &mut output);
        (first, second, third, output[0])
    }
}

/// A matrix of so many rows and columns, row-major, with rows and columns exchanged.
fn transposed(matrix: &[f64], rows: usize, columns: usize) -> Vec<f64> {
    (0..rows * columns).map(|k| matrix[k % rows * columns + k / rows]).collect()
}

/// Name of a layer's tensor in weight files, `layers.0.weight` to `layers.3.bias`.
pub(crate) fn tensor_name(layer: usize, kind: &str) -> String {
    format!("layers.{layer}.{kind}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parameter_count_is_the_papers() {
        assert_eq!(PARAMETERS, 11_777);
        let network = ResidualNetwork::zeros();
        let held: usize = network.layers.iter().map(|l| l.weight.len() + l.bias.len()).sum();
        assert_eq!(held, PARAMETERS);
    }

    #[test]
    fn untrained_adds_nothing_and_depends_on_the_seed() {
        let network = ResidualNetwork::untrained(1);
        assert_eq!(network.evaluate(&[0.3; INPUTS]), 0.0);
        assert_eq!(network, ResidualNetwork::untrained(1));
        assert_ne!(network, ResidualNetwork::untrained(2));
    }

    #[test]
    fn evaluation_follows_a_hand_worked_path_and_keeps_nan() {
        let mut w: Vec<Vec<f64>> = SHAPES.iter().map(|(i, o)| vec![0.0; i * o]).collect();
        let mut b: Vec<Vec<f64>> = SHAPES.iter().map(|(_, o)| vec![0.0; *o]).collect();
        // Unit 5 of layer 0 takes 2 x input 3 - 1; unit 7 takes its negative and is cut.
        w[0][5 * INPUTS + 3] = 2.0;
        b[0][5] = -1.0;
        w[0][7 * INPUTS + 3] = -2.0;
        w[1][9 * HIDDEN[0] + 5] = 3.0;
        w[1][9 * HIDDEN[0] + 7] = 100.0;
        w[2][31 * HIDDEN[1] + 9] = 0.5;
        w[3][31] = -4.0;
        b[3][0] = 0.25;
        let network = ResidualNetwork::from_tensors(
            [&w[0], &w[1], &w[2], &w[3]],
            [&b[0], &b[1], &b[2], &b[3]],
        )
        .expect("shapes");
        let mut input = [0.0; INPUTS];
        input[3] = 1.5; // 2 x 1.5 - 1 = 2, x 3 = 6, x 0.5 = 3, x -4 + 0.25 = -11.75
        assert_eq!(network.evaluate(&input), -11.75);
        assert_eq!(network.matrices()[1], (w[1].clone(), b[1].clone()));
        input[0] = f64::NAN;
        assert!(network.evaluate(&input).is_nan());
    }

    #[test]
    fn slopes_are_those_of_central_differences() {
        // Every weight of an untrained network, and a last layer that lets it through.
        let mut network = ResidualNetwork::untrained(5);
        for (index, weight) in network.layers[3].weight.iter_mut().enumerate() {
            *weight = 0.5 - 0.1 * (index % 9) as f64;
        }
        let input: [f64; INPUTS] = std::array::from_fn(|k| 0.7 - 0.3 * k as f64);
        let (value, slopes) = network.evaluate_with_slopes(&input);
        assert_eq!(value, network.evaluate(&input));
        assert!(slopes.iter().any(|slope| slope.abs() > 1e-3), "{slopes:?}");
        for (k, slope) in slopes.iter().enumerate() {
            let at = |by: f64| {
                let mut moved = input;
                moved[k] += by;
                network.evaluate(&moved)
            };
            // Piecewise linear: exact but for rounding away from kinks.
            let by = 1e-6;
            let found = (at(by) - at(-by)) / (2.0 * by);
            assert!((found - slope).abs() < 1e-8, "input {k}: {found} against {slope}");
        }
    }

    #[test]
    fn a_wrong_shape_or_nan_names_the_tensor() {
        let zeros: Vec<Vec<f64>> = SHAPES.iter().map(|(i, o)| vec![0.0; i * o]).collect();
        let bias: Vec<Vec<f64>> = SHAPES.iter().map(|(_, o)| vec![0.0; *o]).collect();
        let biases = [&bias[0][..], &bias[1], &bias[2], &bias[3]];
        let short = ResidualNetwork::from_tensors(
            [&zeros[0], &zeros[1][1..], &zeros[2], &zeros[3]],
            biases,
        );
        assert!(short.is_err_and(|e| e.to_string().contains("layers.1.weight")));
        let mut broken = zeros[2].clone();
        broken[3] = f64::NAN;
        let nan = ResidualNetwork::from_tensors([&zeros[0], &zeros[1], &broken, &zeros[3]], biases);
        assert!(nan.is_err_and(|e| e.to_string().contains("layers.2.weight")));
    }
}
