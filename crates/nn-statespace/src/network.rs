//! A network with one hidden layer of rectified linear units.

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
            return Err(ModelError::Shape {
                tensor: "hidden.weight".to_owned(),
                expected: vec![hidden, inputs],
                found: vec![w1.len()],
            });
        }
        if w2.len() != hidden {
            return Err(ModelError::Shape {
                tensor: "output.weight".to_owned(),
                expected: vec![hidden],
                found: vec![w2.len()],
            });
        }
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
        let rows = self.w1.chunks_exact(self.inputs);
        let mut output = self.b2;
        for ((row, b), w) in rows.zip(&self.b1).zip(&self.w2) {
            let mut activation = *b;
            for (weight, x) in row.iter().zip(inputs) {
                activation += weight * x;
            }
            // Not f64::max, which would turn a NaN into 0 and hide it.
            output += w * if activation <= 0.0 { 0.0 } else { activation };
        }
        output
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
            let activation = row.iter().zip(inputs).fold(*b, |sum, (weight, x)| sum + weight * x);
            if activation > 0.0 {
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
