//! A fitted scikit-learn `RobustScaler` in a pickle.

use super::floats;
use super::pickle::{self, Value};
use crate::error::ModelError;
use crate::network::shaped;
use crate::scaler::CentreAndScale;

/// Modules under which NumPy, old and new, keeps what rebuilds an array.
const NUMPY_MODULES: [&str; 2] = ["numpy.core.multiarray", "numpy._core.multiarray"];

/// Reads the centres and scales of a scaler fitted to `features` columns, in the file's order.
pub(super) fn read(bytes: &[u8], features: usize) -> Result<Vec<CentreAndScale>, ModelError> {
    let value = pickle::read(bytes, 0)?;
    let Value::Built(scaler) = &value else {
        return Err(ModelError::NotAScaler("no object with a state"));
    };
    if scaler.0.call(&["sklearn.preprocessing._data"], "RobustScaler").is_none() {
        return Err(ModelError::NotAScaler("an object that is not a RobustScaler"));
    }
    let is_on = |key: &str| scaler.1.entry(key) == Some(&Value::Bool(true));
    if !is_on("with_centering") || !is_on("with_scaling") {
        return Err(ModelError::NotAScaler("a scaler that does not centre and scale"));
    }
    let column = |name: &str| -> Result<Vec<f64>, ModelError> {
        let missing = || ModelError::MissingTensor(name.to_owned());
        let values = read_array(name, scaler.1.entry(name).ok_or_else(missing)?)?;
        shaped(name, &[features], &[values.len()])?;
        Ok(values)
    };
    let pairs = column("center_")?.into_iter().zip(column("scale_")?);
    Ok(pairs.map(|(centre, scale)| CentreAndScale { centre, scale }).collect())
}

/// A one-dimensional little-endian NumPy array of 32- or 64-bit floating-point numbers.
fn read_array(name: &str, value: &Value) -> Result<Vec<f64>, ModelError> {
    let bad = |problem| ModelError::BadTensor { tensor: name.to_owned(), problem };
    let state = match value {
        Value::Built(array) if array.0.call(&NUMPY_MODULES, "_reconstruct").is_some() => {
            array.1.tuple()
        }
        _ => None,
    };
    let Some([_, shape, Value::Built(dtype), _, Value::Bytes(content)]) = state else {
        return Err(bad("it is not a NumPy array"));
    };
    let Some([count]) = shape.tuple() else {
        return Err(bad("it does not have one dimension"));
    };
    let count = count.size().ok_or_else(|| bad("it has no length"))?;
    if dtype.1.tuple().and_then(|state| state.get(1)).and_then(Value::text) != Some("<") {
        return Err(bad("its byte order is not little-endian"));
    }
    let kind = dtype.0.call(&["numpy"], "dtype").and_then(Value::tuple).and_then(<[Value]>::first);
    let width = match kind.and_then(Value::text) {
        Some("f4") => 4,
        Some("f8") => 8,
        _ => return Err(bad("its numbers are neither 32- nor 64-bit floating point")),
    };
    if count.checked_mul(width) != Some(content.len()) {
        return Err(bad("its content has another length than its shape needs"));
    }
    floats(name, content, width)
}
