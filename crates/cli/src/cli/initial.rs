//! Where a replay starts, as it is typed.

use std::path::PathBuf;
use std::str::FromStr;

/// Where a replay starts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Initial {
    /// The model's own steady state at the first reading.
    SteadyState,
    /// The row of a published table.
    Table(PathBuf),
}

impl FromStr for Initial {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "steady-state" => Ok(Self::SteadyState),
            Some(("table", file)) if !file.is_empty() => Ok(Self::Table(PathBuf::from(file))),
            _ => Err("expected steady-state or table:FILE".to_owned()),
        }
    }
}
