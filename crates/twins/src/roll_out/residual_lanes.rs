//! The residual network for many samples at a time: products of small matrices, which faer carries
//! out, with samples as columns.

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nn_statespace::kernel::LANES;

use super::Precision;
use crate::inputs::INPUTS;
use crate::residual::{HIDDEN, PARAMETERS, ResidualNetwork, SHAPES};

/// Rows of one layer's outputs (or of the inputs), shape `(units, LANES)`, row-major.
pub(super) type Rows<T> = Vec<[T; LANES]>;

/// What the network computed in one step; the way back needs it.
#[derive(Debug, Clone)]
pub(super) struct Activations<T> {
    /// Inputs in the order of [`crate::INPUT_NAMES`].
    pub(super) input: Rows<T>,
    /// Outputs of the three hidden layers, after ReLU.
    hidden: [Rows<T>; 3],
}

impl<T: Precision> Activations<T> {
    pub(super) fn new() -> Self {
        let rows = |units: usize| vec![[T::ZERO; LANES]; units];
        Self { input: rows(INPUTS), hidden: HIDDEN.map(rows) }
    }
}

/// Slopes of the output by what each hidden layer put out before ReLU; room that steps share.
pub(super) type Slopes<T> = Activations<T>;

/// All weights and biases as one vector: each layer's weights, shape `(inputs, outputs)` row-major,
/// then its biases.
pub(crate) fn parameters_of<T: Precision>(network: &ResidualNetwork) -> Vec<T> {
    let mut parameters = Vec::with_capacity(PARAMETERS);
    for layer in &network.layers {
        parameters.extend(layer.weight.iter().chain(&layer.bias).map(|value| T::of(*value)));
    }
    parameters
}

/// The network of such a vector.
pub(crate) fn network_of<T: Precision>(parameters: &[T]) -> ResidualNetwork {
    debug_assert_eq!(parameters.len(), PARAMETERS);
    let mut network = ResidualNetwork::zeros();
    let mut rest = parameters.iter();
    for layer in &mut network.layers {
        for (value, from) in layer.weight.iter_mut().chain(&mut layer.bias).zip(&mut rest) {
            *value = from.to_f64();
        }
    }
    network
}

/// Where a layer's weights and biases stand in the vector.
fn spans(layer: usize) -> (Range<usize>, Range<usize>) {
    let start: usize = SHAPES[..layer].iter().map(|(inputs, outputs)| (inputs + 1) * outputs).sum();
    let (inputs, outputs) = SHAPES[layer];
    let end = start + inputs * outputs;
    (start..end, end..end + outputs)
}

fn weights<T>(parameters: &[T], layer: usize) -> MatRef<'_, T> {
    let (inputs, outputs) = SHAPES[layer];
    MatRef::from_row_major_slice(&parameters[spans(layer).0], inputs, outputs)
}

fn biases<T>(parameters: &[T], layer: usize) -> &[T] {
    &parameters[spans(layer).1]
}

fn matrix<T>(rows: &Rows<T>) -> MatRef<'_, T> {
    MatRef::from_row_major_slice(rows.as_flattened(), rows.len(), LANES)
}

fn matrix_mut<T>(rows: &mut Rows<T>) -> MatMut<'_, T> {
    let count = rows.len();
    MatMut::from_row_major_slice_mut(rows.as_flattened_mut(), count, LANES)
}

/// The network's output of each sample; `activations.input` holds what it sees.
pub(super) fn evaluate<T: Precision>(
    parameters: &[T],
    activations: &mut Activations<T>,
) -> [T; LANES] {
    let Activations { input, hidden: [first, second, third] } = activations;
    layer(parameters, 0, input, first);
    layer(parameters, 1, first, second);
    layer(parameters, 2, second, third);
    let mut output = [biases(parameters, 3)[0]; LANES];
    for (weight, row) in parameters[spans(3).0].iter().zip(third) {
        for (sum, value) in output.iter_mut().zip(row) {
            *sum += *weight * *value;
        }
    }
    output
}

/// A hidden layer with its ReLU, which lets what is not a number through.
fn layer<T: Precision>(parameters: &[T], index: usize, input: &Rows<T>, output: &mut Rows<T>) {
    for (row, bias) in output.iter_mut().zip(biases(parameters, index)) {
        *row = [*bias; LANES];
    }
    let weights = weights(parameters, index).transpose();
    matmul(matrix_mut(output), Accum::Add, weights, matrix(input), T::of(1.0), Par::Seq);
    for value in output.as_flattened_mut() {
        *value = if *value < T::ZERO { T::ZERO } else { *value };
    }
}

/// Slopes of the output by each layer, and by the inputs Q1 and Q2, which are returned. Units at
/// their kink count as closed.
pub(super) fn slopes<T: Precision>(
    parameters: &[T],
    activations: &Activations<T>,
    slopes: &mut Slopes<T>,
) -> [[T; LANES]; 2] {
    let Slopes { hidden: [first, second, third], input } = slopes;
    let rows = third.iter_mut().zip(&activations.hidden[2]).zip(&parameters[spans(3).0]);
    for ((slope, value), weight) in rows {
        for (slope, value) in slope.iter_mut().zip(value) {
            *slope = if *value > T::ZERO { *weight } else { T::ZERO };
        }
    }
    back(parameters, 2, third, second, &activations.hidden[1]);
    back(parameters, 1, second, first, &activations.hidden[0]);
    // Of the inputs, only Q1 and Q2 depend on what the network did before.
    let weights = weights(parameters, 0).subrows(0, 2);
    let into = MatMut::from_row_major_slice_mut(input[..2].as_flattened_mut(), 2, LANES);
    matmul(into, Accum::Replace, weights, matrix(first), T::of(1.0), Par::Seq);
    [input[0], input[1]]
}

fn back<T: Precision>(
    parameters: &[T],
    layer: usize,
    by_output: &Rows<T>,
    by_input: &mut Rows<T>,
    input: &Rows<T>,
) {
    let weights = weights(parameters, layer);
    matmul(matrix_mut(by_input), Accum::Replace, weights, matrix(by_output), T::of(1.0), Par::Seq);
    for (slope, value) in by_input.as_flattened_mut().iter_mut().zip(input.as_flattened()) {
        *slope = if *value > T::ZERO { *slope } else { T::ZERO };
    }
}

/// Adds to `gradient` the slopes of the parameters where sample `k`'s output counts `factors[k]`
/// times. `slopes` come from [`slopes`] and are used up.
pub(super) fn add_gradient<T: Precision>(
    activations: &Activations<T>,
    slopes: &mut Slopes<T>,
    factors: &[T; LANES],
    gradient: &mut [T],
) {
    for row in slopes.hidden.iter_mut().flatten() {
        for (slope, factor) in row.iter_mut().zip(factors) {
            *slope *= *factor;
        }
    }
    let [first, second, third] = &activations.hidden;
    for (layer, input) in [&activations.input, first, second].into_iter().enumerate() {
        let by_output = &slopes.hidden[layer];
        let (weights, biases) = spans(layer);
        let (inputs, outputs) = SHAPES[layer];
        let into = MatMut::from_row_major_slice_mut(&mut gradient[weights], inputs, outputs);
        let by_output_matrix = matrix(by_output).transpose();
        matmul(into, Accum::Add, matrix(input), by_output_matrix, T::of(1.0), Par::Seq);
        for (sum, row) in gradient[biases].iter_mut().zip(by_output) {
            *sum += total(row.iter().copied());
        }
    }
    let (weights, bias) = spans(3);
    for (sum, row) in gradient[weights].iter_mut().zip(third) {
        *sum += total(row.iter().zip(factors).map(|(value, factor)| *value * *factor));
    }
    gradient[bias.start] += total(factors.iter().copied());
}

/// The sum over lanes, in eight parts that can be added side by side.
fn total<T: Precision>(lanes: impl ExactSizeIterator<Item = T>) -> T {
    let mut parts = [T::ZERO; 8];
    for (lane, value) in lanes.enumerate() {
        parts[lane % 8] += value;
    }
    parts.into_iter().sum()
}
