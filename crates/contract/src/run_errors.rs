//! `run_errors.json`: how far a person's glucose strays from a twin's free run.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The error of free runs of each twin, by person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RunErrors(pub BTreeMap<String, RunError>);

/// The error of free runs of one person's twin.
#[apply(strict!)]
pub struct RunError {
    /// Share of the error of the logarithm of glucose that is left after half an hour.
    pub left: f64,
    /// Standard deviation of what half an hour adds to it, unitless.
    pub added: f64,
    /// From glucose that is drawn with such errors to what is measured as often.
    pub map: QuantileMap,
}

/// A map of glucose that takes one distribution to another; the default changes nothing.
#[apply(strict!)]
#[derive(Default)]
pub struct QuantileMap {
    /// Quantiles of what is mapped, rising, and of what it is mapped to, mg/dL.
    pub knots: Vec<(f64, f64)>,
}
