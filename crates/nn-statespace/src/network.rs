//! A network with one hidden layer of rectified linear units.

use std::fmt::Display;

use crate::error::ModelError;

/// `y = w2 . max(0, w1 x + b1) + b2`, in f64.
///
/// Weights trained or published in f32 are held exactly.
///
/// ```
/// use nn_statespace::HiddenLayerNetwork;
///
/// // |x| as relu(x) + relu(-x)
/// let network = HiddenLayerNetwork::new(1, vec![1.0, -1.0], vec![0.0, 0.0], vec![1.0, 1.0], 0.0)?;
/// assert_eq!(network.evaluate(&[-3.0]), 3.0);
/// # Ok::<(), nn_statespace::ModelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct HiddenLayerNetwork {
    inputs: usize,
    /// Row-major, shape (hidden, inputs).
    w1: Vec<f64>,
    b1: Vec<f64>,
    w2: Vec<f64>,
    b2: f64,
}

impl HiddenLayerNetwork {
    /// A network of `inputs` inputs from its matrices: `w1` of shape (hidden, inputs), row-major,
    /// `b1` and `w2` of shape (hidden), and the scalar `b2`.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if the lengths do not fit together, [`ModelError::NotFinite`] if a
    /// weight is not a finite number.
    pub fn new(
        inputs: usize,
        w1: Vec<f64>,
        b1: Vec<f64>,
        w2: Vec<f64>,
        b2: f64,
    ) -> Result<Self, ModelError> {
        let hidden = b1.len();
        if inputs == 0 || hidden == 0 || hidden.checked_mul(inputs) != Some(w1.len()) {
            // A flat vector in the place of a matrix that it cannot be.
            shaped("hidden.weight", &[hidden, inputs], &[w1.len()])?;
        }
        shaped("output.weight", &[hidden], &[w2.len()])?;
        finite("hidden.weight", &w1)?;
        finite("hidden.bias", &b1)?;
        finite("output.weight", &w2)?;
        finite("output.bias", &[b2])?;
        Ok(Self { inputs, w1, b1, w2, b2 })
    }

    /// The output for one vector of inputs. Does not allocate.
    ///
    /// # Panics
    /// If `inputs` does not have [`Self::inputs`] entries, which is an error of the caller's
    /// program and not of its data.
    #[must_use]
    pub fn evaluate(&self, inputs: &[f64]) -> f64 {
        assert_eq!(inputs.len(), self.inputs, "one value for each input of the network");
        // The numbers of inputs that paper Eq. 2 knows, as constants that unroll the inner loop.
        match self.inputs {
            2 => self.sum_over_units(|row: &[f64; 2], b| activation(row, inputs, b)),
            4 => self.sum_over_units(|row: &[f64; 4], b| activation(row, inputs, b)),
            5 => self.sum_over_units(|row: &[f64; 5], b| activation(row, inputs, b)),
            _ => {
                let units = self.w1.chunks_exact(self.inputs).zip(&self.b1).zip(&self.w2);
                units.fold(self.b2, |sum, ((row, b), w)| {
                    sum + w * rectified(activation(row, inputs, *b))
                })
            }
        }
    }

    /// The output, summed in four interleaved parts so that additions need not wait for each
    /// other; the order is fixed, and so is the rounding.
    fn sum_over_units<const N: usize>(&self, activation: impl Fn(&[f64; N], f64) -> f64) -> f64 {
        let rows = self.w1.as_chunks::<N>().0;
        let (rows_by_four, last_rows) = rows.as_chunks::<4>();
        let (b_by_four, last_b) = self.b1.as_chunks::<4>();
        let (w_by_four, last_w) = self.w2.as_chunks::<4>();
        let mut sums = [0.0; 4];
        for ((rows, b), w) in rows_by_four.iter().zip(b_by_four).zip(w_by_four) {
            for (((sum, row), b), w) in sums.iter_mut().zip(rows).zip(b).zip(w) {
                *sum += w * rectified(activation(row, *b));
            }
        }
        for ((row, b), w) in last_rows.iter().zip(last_b).zip(last_w) {
            sums[0] += w * rectified(activation(row, *b));
        }
        self.b2 + ((sums[0] + sums[1]) + (sums[2] + sums[3]))
    }

    /// Adds the gradient of the output with respect to each input to `gradient`, times `factor`.
    ///
    /// Units exactly at their kink count as inactive, as in the training frameworks.
    ///
    /// # Panics
    /// If `inputs` or `gradient` does not have [`Self::inputs`] entries.
    pub fn add_gradient(&self, inputs: &[f64], factor: f64, gradient: &mut [f64]) {
        assert_eq!(inputs.len(), self.inputs, "one value for each input of the network");
        assert_eq!(gradient.len(), self.inputs, "one slope for each input of the network");
        let rows = self.w1.chunks_exact(self.inputs);
        for ((row, b), w) in rows.zip(&self.b1).zip(&self.w2) {
            if activation(row, inputs, *b) > 0.0 {
                for (slope, weight) in gradient.iter_mut().zip(row) {
                    *slope += factor * w * weight;
                }
            }
        }
    }

    /// Number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Number of hidden units.
    #[must_use]
    pub fn hidden(&self) -> usize {
        self.b1.len()
    }

    /// Weights of the hidden layer, row-major, shape (hidden, inputs).
    #[must_use]
    pub fn w1(&self) -> &[f64] {
        &self.w1
    }

    /// Biases of the hidden layer, shape (hidden).
    #[must_use]
    pub fn b1(&self) -> &[f64] {
        &self.b1
    }

    /// Weights of the output, shape (hidden).
    #[must_use]
    pub fn w2(&self) -> &[f64] {
        &self.w2
    }

    /// Bias of the output.
    #[must_use]
    pub fn b2(&self) -> f64 {
        self.b2
    }
}

/// `row . inputs + bias`.
fn activation(row: &[f64], inputs: &[f64], bias: f64) -> f64 {
    row.iter().zip(inputs).fold(bias, |sum, (weight, x)| sum + weight * x)
}

/// `max(0, value)`, but not `f64::max`, which would turn a NaN into 0 and hide it.
fn rectified(value: f64) -> f64 {
    if value <= 0.0 { 0.0 } else { value }
}

/// Refuses a tensor of another shape than the `expected` one.
pub(crate) fn shaped(
    tensor: impl Display,
    expected: &[usize],
    found: &[usize],
) -> Result<(), ModelError> {
    if expected == found {
        return Ok(());
    }
    let (expected, found) = (expected.to_vec(), found.to_vec());
    Err(ModelError::Shape { tensor: tensor.to_string(), expected, found })
}

/// Refuses a tensor that holds something other than finite numbers.
pub(crate) fn finite(tensor: &str, values: &[f64]) -> Result<(), ModelError> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(ModelError::NotFinite { tensor: tensor.to_owned(), index }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> HiddenLayerNetwork {
        HiddenLayerNetwork::new(
            2,
            vec![1.0, 2.0, -1.0, 0.5, 0.0, -1.0],
            vec![0.5, 0.0, 1.0],
            vec![2.0, -1.0, 4.0],
            0.25,
        )
        .expect("shapes fit")
    }

    #[test]
    fn the_output_is_that_of_the_formula() {
        // activations 1.0 + 4.0 + 0.5 = 5.5, -1 + 1 = 0, -2 + 1 = -1 (off)
        assert_eq!(example().evaluate(&[1.0, 2.0]), 2.0 * 5.5 + 0.25);
    }

    #[test]
    fn every_number_of_inputs_and_units_gives_the_formula() {
        for inputs in 1..7 {
            for hidden in 1..10 {
                let value = |i: usize| ((7 * i + 3) % 11) as f64 - 5.0;
                let (w1, b1): (Vec<f64>, Vec<f64>) =
                    ((0..hidden * inputs).map(value).collect(), (0..hidden).map(value).collect());
                let w2: Vec<f64> = (0..hidden).map(|i| value(i + 4)).collect();
                let x: Vec<f64> = (0..inputs).map(|i| value(i + 2)).collect();
                let mut expected = 2.0;
                for ((row, b), w) in w1.chunks_exact(inputs).zip(&b1).zip(&w2) {
                    let sum: f64 = row.iter().zip(&x).map(|(weight, x)| weight * x).sum();
                    expected += w * (sum + b).max(0.0);
                }
                let network = HiddenLayerNetwork::new(inputs, w1, b1, w2, 2.0).expect("fits");
                assert_eq!(network.evaluate(&x), expected, "{inputs} {hidden}"); // whole numbers
            }
        }
    }

    #[test]
    fn a_value_that_is_not_a_number_comes_out_as_one() {
        assert!(example().evaluate(&[f64::NAN, 0.0]).is_nan());
    }

    #[test]
    fn the_gradient_is_that_of_the_active_units() {
        let mut gradient = [0.0; 2];
        example().add_gradient(&[1.0, 2.0], 1.0, &mut gradient);
        assert_eq!(gradient, [2.0, 4.0]);
        example().add_gradient(&[-1.0, 0.0], 0.5, &mut gradient);
        // units 2 (slope -1 x (-1, 0.5)) and 3 (4 x (0, -1)) are active, each times 0.5
        assert_eq!(gradient, [2.0 + 0.5, 4.0 - 0.25 - 2.0]);
    }

    #[test]
    fn misfitting_or_infinite_matrices_are_refused_by_name() {
        let new = HiddenLayerNetwork::new;
        let error = new(2, vec![1.0; 5], vec![0.0; 3], vec![1.0; 3], 0.0).expect_err("5 is not 6");
        assert_eq!(
            error.to_string(),
            "tensor hidden.weight: expected shape [3, 2], found [5]; is this the right file?"
        );
        let error = new(1, vec![1.0; 2], vec![0.0; 2], vec![1.0; 3], 0.0).expect_err("3 is not 2");
        assert!(error.to_string().contains("output.weight"), "{error}");
        let error = new(1, vec![1.0], vec![f64::NAN], vec![1.0], 0.0).expect_err("NaN");
        assert!(error.to_string().contains("hidden.bias"), "{error}");
    }
}
