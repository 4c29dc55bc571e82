//! What can go wrong in this crate.

use physiology::{Compartment, SimulationError};

/// Errors of the ODE plant and of what is built on it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OdeError {
    /// A model parameter cannot be.
    #[error("parameter {name} is {value}; it must be a positive finite number")]
    Parameter {
        /// The parameter's field name.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// An argument lies outside the range in which the question has an answer.
    #[error("{name} is {value}; it must be {requirement}")]
    Argument {
        /// The argument's name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// No basal rate holds the glucose that was asked for.
    #[error(
        "no non-negative basal rate holds {glucose} mg/dL (uptake and renal clearance exceed \
         production without insulin); ask for a lower glucose"
    )]
    NoBasal {
        /// The target, mg/dL.
        glucose: f64,
    },
    /// Newton's method stopped before the residual was small enough.
    #[error(
        "steady state at {glucose} mg/dL not found: residual {residual} after {iterations} \
         iterations; check the parameters"
    )]
    SteadyState {
        /// The target, mg/dL.
        glucose: f64,
        /// Largest absolute derivative at the last iterate.
        residual: f64,
        /// Iterations made.
        iterations: usize,
    },
    /// A compartment took a value that is not a finite number.
    #[error(
        "{compartment} is not a finite number; check the parameters, the initial state and the \
         doses"
    )]
    NonFinite {
        /// The compartment at fault.
        compartment: Compartment,
    },
    /// The adaptive integrator gave up.
    #[error(
        "adaptive integration with rtol {rtol} and atol {atol} stopped: {reason}; loosen the \
         tolerances"
    )]
    Integration {
        /// Relative tolerance that was asked for.
        rtol: f64,
        /// Absolute tolerance that was asked for.
        atol: f64,
        /// What the solver said.
        reason: String,
    },
    /// A simulation stopped.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// No candidate passed the physiological tests within the number of draws allowed.
    #[error(
        "virtual person {index}: none of {draws} draws passed the physiological tests; check the \
         nominal parameters"
    )]
    NoVirtualPerson {
        /// Index of the person in the population.
        index: u64,
        /// Draws made.
        draws: usize,
    },
}

/// Refuses an argument of which what is required does not hold.
pub(crate) fn require(
    holds: bool,
    name: &'static str,
    value: f64,
    requirement: &'static str,
) -> Result<(), OdeError> {
    if holds { Ok(()) } else { Err(OdeError::Argument { name, value, requirement }) }
}

/// Refuses an argument that is not positive and finite.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), OdeError> {
    require(value.is_finite() && value > 0.0, name, value, "positive and finite")
}

/// Refuses an argument that is negative or not finite.
pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<(), OdeError> {
    require(value.is_finite() && value >= 0.0, name, value, "zero or more, finite")
}
