//! A network of one hidden layer with rectified linear units and one output, as plain matrices.
//!
//! `N(x) = b2 + sum_j w2_j max(0, sum_i w1_ji x_i + b1_j)`, the form of every sub-network of the
//! paper's population model (its section "Network architecture"). Where the weights come from is
//! the caller's business.

use std::collections::HashSet;

use crate::error::ConformanceError;

/// A one-hidden-layer ReLU network with named inputs and a named output, in scaled units.
#[derive(Clone, Debug, PartialEq)]
pub struct OneHiddenLayer {
    output: String,
    inputs: Vec<String>,
    w1: Vec<f64>,
    b1: Vec<f64>,
    w2: Vec<f64>,
    b2: f64,
}

impl OneHiddenLayer {
    /// A network from its matrices.
    ///
    /// `output` is the state whose derivative the network gives (scaled units per minute),
    /// `inputs` the names of its inputs in the order of the columns of `w1`. Shapes: `w1` (hidden x
    /// inputs) row by row, `b1` (hidden), `w2` (hidden), `b2` a number.
    ///
    /// # Errors
    /// [`ConformanceError::Empty`], [`ConformanceError::DuplicateInput`],
    /// [`ConformanceError::Shape`] and [`ConformanceError::NonFiniteWeight`].
    pub fn new(
        output: impl Into<String>,
        inputs: Vec<String>,
        w1: Vec<f64>,
        b1: Vec<f64>,
        w2: Vec<f64>,
        b2: f64,
    ) -> Result<Self, ConformanceError> {
        let network = output.into();
        for (what, length) in [("inputs", inputs.len()), ("hidden neurons", b1.len())] {
            if length == 0 {
                return Err(ConformanceError::Empty { network, what });
            }
        }
        let mut seen = HashSet::new();
        if let Some(input) = inputs.iter().find(|name| !seen.insert(name.as_str())) {
            return Err(ConformanceError::DuplicateInput { network, input: input.clone() });
        }
        let hidden = b1.len();
        check_arrays(
            &network,
            &[
                ("w1", &w1, hidden * inputs.len()),
                ("b1", &b1, hidden),
                ("w2", &w2, hidden),
                ("b2", &[b2], 1),
            ],
        )?;
        Ok(Self { output: network, inputs, w1, b1, w2, b2 })
    }

    /// Name of the output: the state whose derivative this is.
    #[must_use]
    pub fn output(&self) -> &str {
        &self.output
    }

    /// Names of the inputs, in the order of a point's coordinates.
    #[must_use]
    pub fn inputs(&self) -> &[String] {
        &self.inputs
    }

    /// Number of hidden neurons.
    #[must_use]
    pub fn hidden(&self) -> usize {
        self.b1.len()
    }

    /// Input weights of neuron `neuron`, one per input.
    ///
    /// # Panics
    /// Where there is no such neuron, as slices do.
    #[must_use]
    pub fn input_weights(&self, neuron: usize) -> &[f64] {
        let width = self.inputs.len();
        &self.w1[neuron * width..(neuron + 1) * width]
    }

    /// Biases of the hidden neurons, shape (hidden).
    #[must_use]
    pub fn hidden_biases(&self) -> &[f64] {
        &self.b1
    }

    /// Output weights, shape (hidden).
    #[must_use]
    pub fn output_weights(&self) -> &[f64] {
        &self.w2
    }

    /// Output bias, scaled units per minute.
    #[must_use]
    pub fn output_bias(&self) -> f64 {
        self.b2
    }

    /// What hidden neuron `neuron` sees at `point`, before its ReLU.
    pub(crate) fn activation(&self, neuron: usize, point: &[f64]) -> f64 {
        let products = self.input_weights(neuron).iter().zip(point).map(|(w, x)| w * x);
        products.sum::<f64>() + self.b1[neuron]
    }

    /// The same hidden layer under other output weights and another output bias.
    ///
    /// # Errors
    /// [`ConformanceError::Shape`] and [`ConformanceError::NonFiniteWeight`].
    pub fn with_output(&self, w2: Vec<f64>, b2: f64) -> Result<Self, ConformanceError> {
        let Self { output, inputs, w1, b1, .. } = self.clone();
        Self::new(output, inputs, w1, b1, w2, b2)
    }

    /// Position of an input.
    ///
    /// # Errors
    /// [`ConformanceError::UnknownInput`].
    pub fn input_index(&self, input: &str) -> Result<usize, ConformanceError> {
        position(&self.output, &self.inputs, input)
    }

    /// The network's value at `point` in ordinary floating point, scaled units per minute.
    ///
    /// Verdicts do not rest on this; they use exact arithmetic.
    ///
    /// # Errors
    /// [`ConformanceError::Point`].
    pub fn evaluate(&self, point: &[f64]) -> Result<f64, ConformanceError> {
        check_point(&self.output, self.inputs.len(), point, 0)?;
        let outputs = (0..self.hidden()).map(|j| self.w2[j] * self.activation(j, point).max(0.0));
        Ok(outputs.sum::<f64>() + self.b2)
    }
}

/// Refuses arrays that do not have the length beside them or hold what is not a finite number.
pub(crate) fn check_arrays(
    network: &str,
    arrays: &[(&'static str, &[f64], usize)],
) -> Result<(), ConformanceError> {
    let network = || network.to_owned();
    for &(array, values, expected) in arrays {
        let found = values.len();
        if found != expected {
            return Err(ConformanceError::Shape { network: network(), array, found, expected });
        }
    }
    for &(array, values, _) in arrays {
        if let Some((index, &value)) = values.iter().enumerate().find(|(_, v)| !v.is_finite()) {
            let network = network();
            return Err(ConformanceError::NonFiniteWeight { network, array, index, value });
        }
    }
    Ok(())
}

/// Refuses a point that is not `expected` finite numbers; `index` names it in the error.
pub(crate) fn check_point(
    network: &str,
    expected: usize,
    point: &[f64],
    index: usize,
) -> Result<(), ConformanceError> {
    if point.len() == expected && point.iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    Err(ConformanceError::Point { network: network.to_owned(), index, expected })
}

/// Position of an input of a network.
pub(crate) fn position(
    network: &str,
    inputs: &[String],
    input: &str,
) -> Result<usize, ConformanceError> {
    inputs.iter().position(|name| name == input).ok_or_else(|| ConformanceError::UnknownInput {
        network: network.to_owned(),
        input: input.to_owned(),
        known: inputs.to_vec(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn build(w1: Vec<f64>, b1: Vec<f64>, w2: Vec<f64>, b2: f64) -> Result<OneHiddenLayer, String> {
        let inputs = vec!["a".to_owned(), "b".to_owned()];
        OneHiddenLayer::new("y", inputs, w1, b1, w2, b2).map_err(|error| error.to_string())
    }

    #[test]
    fn evaluates_the_formula() {
        let network = build(vec![1.0, 2.0, -1.0, 0.5], vec![-1.0, 0.0], vec![3.0, 2.0], 0.25)
            .expect("valid network");
        // 3 max(0, 1 + 4 - 1) + 2 max(0, -1 + 1) + 0.25, exact in binary.
        assert_eq!(network.evaluate(&[1.0, 2.0]).expect("two coordinates"), 12.25);
        assert_eq!(network.evaluate(&[-4.0, 0.0]).expect("two coordinates"), 8.25);
        assert!(network.evaluate(&[1.0]).is_err());
        assert!(network.evaluate(&[1.0, f64::NAN]).is_err());
    }

    #[test]
    fn refuses_what_is_not_a_network() {
        let cases = [
            (build(vec![1.0; 3], vec![0.0; 2], vec![1.0; 2], 0.0), "w1 has 3 values, expected 4"),
            (build(vec![1.0; 4], vec![0.0; 2], vec![1.0; 3], 0.0), "w2 has 3 values, expected 2"),
            (build(vec![], vec![], vec![], 0.0), "no hidden neurons"),
            (build(vec![1.0; 4], vec![0.0, f64::NAN], vec![1.0; 2], 0.0), "b1[1] is NaN"),
            (build(vec![1.0; 4], vec![0.0; 2], vec![1.0; 2], f64::INFINITY), "b2[0] is inf"),
        ];
        for (built, message) in cases {
            let error = built.expect_err("invalid network");
            assert!(error.contains(message), "{error}");
        }
        let twice = vec!["a".to_owned(), "a".to_owned()];
        let error = OneHiddenLayer::new("y", twice, vec![1.0; 2], vec![0.0], vec![1.0], 0.0)
            .expect_err("repeated name");
        assert!(error.to_string().contains("'a' is named twice"), "{error}");
    }
}
