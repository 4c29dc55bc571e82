//! Sub-networks out of a model file.

use std::collections::BTreeSet;

use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde_json::Value;

use crate::Rejection;

/// A sub-network of one hidden layer: `b2 + sum of v_j max(0, w_j x + b_j)`. The output bias plays no part in slopes.
#[derive(Clone, Debug)]
pub struct Network {
    /// Names of the inputs in the order of the weights.
    pub inputs: Vec<String>,
    /// w, neuron by neuron.
    pub weights: Vec<Vec<f64>>,
    /// b.
    pub biases: Vec<f64>,
    /// v.
    pub output: Vec<f64>,
}

impl Network {
    /// The sub-network of this name in a `population.safetensors`.
    ///
    /// # Errors
    /// [`Rejection::Model`].
    pub fn read(file: &[u8], name: &str) -> Result<Self, Rejection> {
        let wrong = Rejection::Model;
        let (_, header) =
            SafeTensors::read_metadata(file).map_err(|error| wrong(error.to_string()))?;
        let told = header
            .metadata()
            .as_ref()
            .and_then(|metadata| metadata.get("population"))
            .ok_or_else(|| wrong("no entry 'population' in its header".to_owned()))?;
        let told: Value =
            serde_json::from_str(told).map_err(|error| wrong(format!("its header: {error}")))?;
        let inputs: Vec<String> = told["wiring"][name]
            .as_array()
            .and_then(|inputs| {
                inputs.iter().map(|input| input.as_str().map(str::to_owned)).collect()
            })
            .ok_or_else(|| wrong(format!("no wiring of a network '{name}'")))?;
        // The slope by an input that is there twice is the sum of two columns.
        let mut seen = BTreeSet::new();
        if let Some(input) = inputs.iter().find(|input| !seen.insert(input.as_str())) {
            return Err(wrong(format!("'{input}' is wired to '{name}' twice")));
        }
        let tensors = SafeTensors::deserialize(file).map_err(|error| wrong(error.to_string()))?;
        let of = |part: &str| -> Result<(Vec<usize>, Vec<f64>), Rejection> {
            let tensor = tensors
                .tensor(&format!("{name}.{part}"))
                .map_err(|error| wrong(format!("{name}.{part}: {error}")))?;
            Ok((tensor.shape().to_vec(), numbers(&tensor, &format!("{name}.{part}"))?))
        };
        let (shape, rows) = of("hidden.weight")?;
        let (_, biases) = of("hidden.bias")?;
        let (_, output) = of("output.weight")?;
        let hidden = biases.len();
        if inputs.is_empty() || shape != [hidden, inputs.len()] || output.len() != hidden {
            return Err(wrong(format!("the tensors of '{name}' do not fit together")));
        }
        let weights = rows.chunks_exact(inputs.len()).map(<[f64]>::to_vec).collect();
        Ok(Self { inputs, weights, biases, output })
    }
}

fn numbers(tensor: &TensorView<'_>, name: &str) -> Result<Vec<f64>, Rejection> {
    let values: Vec<f64> = match tensor.dtype() {
        Dtype::F64 => tensor
            .data()
            .chunks_exact(8)
            .map(|bytes| f64::from_le_bytes(bytes.try_into().expect("eight bytes")))
            .collect(),
        Dtype::F32 => tensor
            .data()
            .chunks_exact(4)
            .map(|bytes| f64::from(f32::from_le_bytes(bytes.try_into().expect("four bytes"))))
            .collect(),
        other => return Err(Rejection::Model(format!("{name} is of type {other:?}, not a float"))),
    };
    if values.iter().any(|value| !value.is_finite()) {
        return Err(Rejection::Model(format!("{name} holds what is not a finite number")));
    }
    Ok(values)
}
