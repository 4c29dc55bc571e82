//! What can go wrong with a model, its files and its training.

use physiology::{Compartment, MgPerDl};

use crate::signal::Signal;

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
    #[error("network {0} has no hidden units; give it at least one")]
    NoHiddenUnits(Compartment),
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
    /// A gain of a dose that is no positive number.
    #[error("gain of {signal}: {gain}; it must be positive and finite")]
    DoseGain {
        /// The dose.
        signal: Signal,
        /// Its gain.
        gain: f64,
    },
    /// The scaler of a signal cannot be fitted to nothing.
    #[error("scaler of {0}: no rows to fit it to")]
    NoRows(Signal),
    /// A PyTorch file is not the archive it should be.
    #[error("archive, offset {offset}: {problem}; is the file complete?")]
    Archive {
        /// Where in the file.
        offset: usize,
        /// What stands there.
        problem: &'static str,
    },
    /// An archive lacks the entry with this name, or one that ends so.
    #[error("archive: no entry '{0}'; is this a PyTorch state dictionary?")]
    MissingEntry(String),
    /// A pickle holds something that files of this kind do not.
    #[error(
        "pickle, offset {offset}, opcode {opcode:#04x}: {problem}; is this the file that the \
         authors published?"
    )]
    Pickle {
        /// Where in the file the opcode stands.
        offset: usize,
        /// The opcode, or 0 where none could be read.
        opcode: u8,
        /// What is wrong there.
        problem: &'static str,
    },
    /// A PyTorch file does not hold a dictionary of tensors, but this.
    #[error("not a state dictionary: {0}; save `model.state_dict()` and nothing around it")]
    NotAStateDict(&'static str),
    /// A pickle does not hold a fitted robust scaler, but this.
    #[error("not a robust scaler: {0}; expected a pickled scikit-learn RobustScaler")]
    NotAScaler(&'static str),
    /// A file lacks the tensor of this name.
    #[error("tensor {0}: not in the file; is this the right kind of model?")]
    MissingTensor(String),
    /// A tensor is not usable.
    #[error("tensor {tensor}: {problem}")]
    BadTensor {
        /// Name of the tensor in its file.
        tensor: String,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A table of initial states is not readable.
    #[error("initial states, line {line}, column {column}: {problem}")]
    InitialTable {
        /// The line, counted from 1.
        line: usize,
        /// The column's name; empty where the line as a whole is at fault.
        column: String,
        /// What is wrong there.
        problem: String,
    },
    /// A table of initial states has no row for a glucose value.
    #[error("initial states: no row for {glucose}; the table goes from {lowest} to {highest}")]
    GlucoseOutsideTable {
        /// The value asked for.
        glucose: MgPerDl,
        /// The table's lowest.
        lowest: MgPerDl,
        /// The table's highest.
        highest: MgPerDl,
    },
    /// A glucose value cannot be.
    #[error("initial state: {0} is not a positive finite glucose concentration")]
    Glucose(MgPerDl),
    /// Runs cannot be cut into windows.
    #[error("windows, run {run}: {problem}")]
    Windows {
        /// The run at fault, counted from 0.
        run: usize,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// Training cannot start or go on.
    #[error("training: {0}")]
    Training(String),
    /// A tensor operation failed.
    #[error("tensor operation: {0}")]
    Tensor(#[from] candle_core::Error),
    /// A weight file is not readable.
    #[error("weight file: {0}; expected a population.safetensors of this project")]
    WeightFile(String),
}
