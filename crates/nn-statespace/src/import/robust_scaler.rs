//! A fitted scikit-learn `RobustScaler` in a pickle.

use super::pickle::{self, Value};
use crate::error::ModelError;
use crate::scaler::CentreAndScale;

/// Modules under which NumPy, old and new, keeps what rebuilds an array.
const NUMPY_MODULES: [&str; 2] = ["numpy.core.multiarray", "numpy._core.multiarray"];

/// Reads the centres and scales of a scaler fitted to `features` columns, in the file's order.
pub(super) fn read(bytes: &[u8], features: usize) -> Result<Vec<CentreAndScale>, ModelError> {
    let value = pickle::read(bytes, 0)?;
    let Value::Built(scaler) = &value else {
        return Err(ModelError::NotAScaler { found: "no object with a state" });
    };
    let is_scaler = matches!(&scaler.0, Value::Call(call)
        if call.0.is_global(&["sklearn.preprocessing._data"], "RobustScaler"));
    if !is_scaler {
        return Err(ModelError::NotAScaler { found: "an object that is not a RobustScaler" });
    }
    for key in ["with_centering", "with_scaling"] {
        if scaler.1.entry(key) != Some(&Value::Bool(true)) {
            return Err(ModelError::NotAScaler {
                found: "a scaler that does not centre and scale",
            });
        }
    }
    let column = |name: &str| -> Result<Vec<f64>, ModelError> {
        let array = scaler
            .1
            .entry(name)
            .ok_or_else(|| ModelError::MissingTensor { tensor: name.to_owned() })?;
        let values = read_array(name, array)?;
        if values.len() != features {
            return Err(ModelError::Shape {
                tensor: name.to_owned(),
                expected: vec![features],
                found: vec![values.len()],
            });
        }
        Ok(values)
    };
    let (centres, scales) = (column("center_")?, column("scale_")?);
    Ok(centres
        .into_iter()
        .zip(scales)
        .map(|(centre, scale)| CentreAndScale { centre, scale })
        .collect())
}

/// A one-dimensional little-endian NumPy array of 32- or 64-bit floating-point numbers.
fn read_array(name: &str, value: &Value) -> Result<Vec<f64>, ModelError> {
    let bad = |problem| ModelError::BadTensor { tensor: name.to_owned(), problem };
    let Value::Built(array) = value else {
        return Err(bad("it is not a NumPy array"));
    };
    if !matches!(&array.0, Value::Call(call) if call.0.is_global(&NUMPY_MODULES, "_reconstruct")) {
        return Err(bad("it is not a NumPy array"));
    }
    let Some([_, shape, Value::Built(dtype), _, Value::Bytes(content)]) = array.1.tuple() else {
        return Err(bad("it is not a NumPy array"));
    };
    let Some([count]) = shape.tuple() else {
        return Err(bad("it does not have one dimension"));
    };
    let count = count.size().ok_or_else(|| bad("it has no length"))?;
    let kind = match &dtype.0 {
        Value::Call(call) if call.0.is_global(&["numpy"], "dtype") => {
            call.1.tuple().and_then(<[Value]>::first).and_then(Value::text)
        }
        _ => None,
    };
    if dtype.1.tuple().and_then(|state| state.get(1)).and_then(Value::text) != Some("<") {
        return Err(bad("its byte order is not little-endian"));
    }
    let (values, rest): (Vec<f64>, usize) = match kind {
        Some("f4") => {
            let (chunks, rest) = content.as_chunks::<4>();
            (chunks.iter().map(|four| f64::from(f32::from_le_bytes(*four))).collect(), rest.len())
        }
        Some("f8") => {
            let (chunks, rest) = content.as_chunks::<8>();
            (chunks.iter().map(|eight| f64::from_le_bytes(*eight)).collect(), rest.len())
        }
        _ => return Err(bad("its numbers are neither 32- nor 64-bit floating point")),
    };
    if rest != 0 || values.len() != count {
        return Err(bad("its content has another length than its shape needs"));
    }
    crate::network::finite(name, &values)?;
    Ok(values)
}
