//! What can go wrong in this crate.

use ode_sim::OdeError;

/// Errors of meal detection and of reconciliation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MealError {
    /// A recorded value cannot be.
    #[error("person '{person}', step {step}, column {column}: {value} is not {requirement}")]
    Value {
        /// The person's identifier.
        person: String,
        /// Step of the record.
        step: usize,
        /// Column of the record.
        column: &'static str,
        /// The value.
        value: f64,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// A body weight cannot be.
    #[error("person '{person}': a weight of {value} kg; give a positive number or leave it empty")]
    Weight {
        /// The person's identifier.
        person: String,
        /// The value, kg.
        value: f64,
    },
    /// A setting cannot be.
    #[error("setting {name} is {value}; it must be {requirement}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// A detection lies outside the record that it is said to be of.
    #[error("person '{person}': a meal was detected at step {step}, the record has {steps} steps")]
    Outside {
        /// The person's identifier.
        person: String,
        /// Step of the detection.
        step: usize,
        /// Steps of the record.
        steps: usize,
    },
    /// The plant failed.
    #[error("person '{person}', step {step}: {source}")]
    Plant {
        /// The person's identifier.
        person: String,
        /// Step of the record.
        step: usize,
        /// What failed.
        source: OdeError,
    },
}

/// Refuses a setting that does not fit.
pub(crate) fn require(
    fits: bool,
    name: &'static str,
    value: f64,
    requirement: &'static str,
) -> Result<(), MealError> {
    if fits { Ok(()) } else { Err(MealError::Setting { name, value, requirement }) }
}
