//! What can go wrong with a model, its files and its training.

use physiology::Compartment;

use crate::wiring::Signal;

/// Errors of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A network's list of inputs is not usable.
    #[error("wiring of network {network}: {problem}")]
    Wiring {
        /// The network at fault.
        network: Compartment,
        /// What is wrong with it.
        problem: String,
    },
    /// A network was given no hidden units.
    #[error("network {network} has no hidden units; give it at least one")]
    NoHiddenUnits {
        /// The network at fault.
        network: Compartment,
    },
    /// A tensor does not have the shape that the model needs.
    #[error(
        "tensor {tensor}: expected shape {expected:?}, found {found:?}; is this the right file?"
    )]
    Shape {
        /// Name of the tensor in its file.
        tensor: String,
        /// The shape that fits.
        expected: Vec<usize>,
        /// The shape that was there.
        found: Vec<usize>,
    },
    /// A tensor or column holds something that is not a finite number.
    #[error("tensor {tensor}: entry {index} is not a finite number")]
    NotFinite {
        /// Name of the tensor or signal.
        tensor: String,
        /// Position of the first such entry, counted from 0 in row-major order.
        index: usize,
    },
    /// A scaler's constant is not usable.
    #[error(
        "scaler of {signal}: centre {centre}, scale {scale}; both must be finite and the scale positive"
    )]
    Scale {
        /// The signal at fault.
        signal: Signal,
        /// Its centre, physical units.
        centre: f64,
        /// Its scale, physical units.
        scale: f64,
    },
    /// A scaler cannot be fitted to nothing.
    #[error("scaler of {signal}: no rows to fit it to")]
    NoRows {
        /// The signal at fault.
        signal: Signal,
    },
}
