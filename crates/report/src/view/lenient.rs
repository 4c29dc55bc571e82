//! Reading what may be missing, null, or of a form that this version does not know.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer};
use serde_json::Value;

/// A value that is shown as absent unless it is there and has the form that is expected.
///
/// # Errors
/// Only where the text is no JSON.
pub(super) fn lenient<'de, D, T>(from: D) -> Result<Option<T>, D::Error>
where
    D: Deserializer<'de>,
    T: DeserializeOwned,
{
    Value::deserialize(from).map(|value| serde_json::from_value(value).ok())
}

/// A list; entries that do not have the form that is expected are left out, and null is no entry.
///
/// # Errors
/// Where there is something other than a list or null.
pub(super) fn entries<'de, D, T>(from: D) -> Result<Vec<T>, D::Error>
where
    D: Deserializer<'de>,
    T: DeserializeOwned,
{
    let values: Option<Vec<Value>> = Option::deserialize(from)?;
    let read = |value| serde_json::from_value(value).ok();
    Ok(values.into_iter().flatten().filter_map(read).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Deserialize)]
    struct Read {
        #[serde(default, deserialize_with = "lenient")]
        number: Option<f64>,
        #[serde(default, deserialize_with = "entries")]
        list: Vec<u32>,
    }

    #[test]
    fn what_does_not_fit_is_absent() {
        for (text, number, list) in [
            ("{}", None, vec![]),
            (r#"{"number": null, "list": null}"#, None, vec![]),
            (r#"{"number": "many", "list": [1, "two", 3, null]}"#, None, vec![1, 3]),
            (r#"{"number": 2.5, "list": []}"#, Some(2.5), vec![]),
        ] {
            let read: Read = serde_json::from_str(text).expect("tolerated");
            assert_eq!(read, Read { number, list }, "{text}");
        }
    }
}
