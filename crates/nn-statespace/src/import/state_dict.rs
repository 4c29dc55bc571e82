//! A PyTorch state dictionary: named tensors in a ZIP container.

use super::archive::Archive;
use super::floats;
use super::pickle::{self, Value};
use crate::error::ModelError;
use crate::network::shaped;

/// A tensor with its values in row-major order.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NamedTensor {
    pub(super) name: String,
    pub(super) shape: Vec<usize>,
    pub(super) values: Vec<f64>,
}

/// The tensors of a state dictionary that have not been taken yet.
#[derive(Debug)]
pub(super) struct StateDict {
    tensors: Vec<NamedTensor>,
}

impl StateDict {
    /// Reads every tensor of a file that `torch.save(model.state_dict())` wrote.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, ModelError> {
        let archive = Archive::open(bytes)?;
        let root = archive.root_of("data.pkl")?;
        let (pickled, base) = archive.read(&format!("{root}data.pkl"))?;
        let mut value = pickle::read(pickled, base)?;
        // state_dict() is an OrderedDict with an attribute (`_metadata`), hence built upon.
        if let Value::Built(parts) = value {
            value = parts.0.clone();
        }
        let Value::Dict(items) = value else {
            return Err(ModelError::NotAStateDict("something other than a dictionary"));
        };
        let mut tensors: Vec<NamedTensor> = Vec::with_capacity(items.len());
        for (key, value) in &items {
            let no_text = ModelError::NotAStateDict("a key that is not text");
            let name = key.text().ok_or(no_text)?.to_owned();
            if tensors.iter().any(|tensor| tensor.name == name) {
                return Err(ModelError::BadTensor { tensor: name, problem: "it appears twice" });
            }
            tensors.push(read_tensor(&archive, root, name, value)?);
        }
        Ok(Self { tensors })
    }

    /// Takes the tensor `name` out.
    pub(super) fn take(&mut self, name: &str) -> Result<NamedTensor, ModelError> {
        match self.tensors.iter().position(|tensor| tensor.name == name) {
            Some(position) => Ok(self.tensors.remove(position)),
            None => Err(ModelError::MissingTensor(name.to_owned())),
        }
    }

    /// Takes the tensor `name` out if its shape is `shape`.
    pub(super) fn take_shaped(
        &mut self,
        name: &str,
        shape: &[usize],
    ) -> Result<Vec<f64>, ModelError> {
        let tensor = self.take(name)?;
        shaped(name, shape, &tensor.shape)?;
        Ok(tensor.values)
    }

    /// Refuses tensors that nobody asked for.
    pub(super) fn finish(self) -> Result<(), ModelError> {
        match self.tensors.into_iter().next() {
            Some(tensor) => Err(ModelError::BadTensor {
                tensor: tensor.name,
                problem: "it does not belong to this kind of model",
            }),
            None => Ok(()),
        }
    }
}

/// Follows `_rebuild_tensor_v2(storage, offset, size, stride, requires_grad, hooks)`.
fn read_tensor(
    archive: &Archive<'_>,
    root: &str,
    name: String,
    value: &Value,
) -> Result<NamedTensor, ModelError> {
    let bad = |problem| ModelError::BadTensor { tensor: name.clone(), problem };
    let arguments = value.call(&["torch._utils"], "_rebuild_tensor_v2").and_then(Value::tuple);
    let Some([Value::Persistent(storage), offset, size, stride, ..]) = arguments else {
        return Err(bad("it is not a tensor"));
    };
    let Some([_, kind, key, _, length]) = storage.tuple() else {
        return Err(bad("its storage is not described"));
    };
    let width = if kind.is_global(&["torch"], "FloatStorage") {
        4
    } else if kind.is_global(&["torch"], "DoubleStorage") {
        8
    } else {
        return Err(bad("its numbers are neither 32- nor 64-bit floating point"));
    };
    let (Some(key), Some(length), Some(offset)) = (key.text(), length.size(), offset.size()) else {
        return Err(bad("its storage is not described"));
    };
    let sizes =
        |value: &Value| -> Option<Vec<usize>> { value.tuple()?.iter().map(Value::size).collect() };
    let (Some(shape), Some(stride)) = (sizes(size), sizes(stride)) else {
        return Err(bad("its shape is not described"));
    };
    let mut count: usize = 1;
    let mut row_major = vec![0; shape.len()];
    for (axis, extent) in shape.iter().enumerate().rev() {
        row_major[axis] = count;
        count = count.checked_mul(*extent).ok_or_else(|| bad("its shape is too large"))?;
    }
    if stride != row_major {
        return Err(bad("it is not stored row by row"));
    }
    let (content, _) = archive.read(&format!("{root}data/{key}"))?;
    let end = offset.checked_add(count).ok_or_else(|| bad("its shape is too large"))?;
    if length.checked_mul(width) != Some(content.len()) || end > length {
        return Err(bad("its storage has another length than its shape needs"));
    }
    let values = floats(&name, &content[offset * width..end * width], width)?;
    Ok(NamedTensor { name, shape, values })
}
