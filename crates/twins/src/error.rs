//! What can go wrong in this crate.

use cohort::CohortError;
use nn_statespace::ModelError;
use ode_sim::OdeError;
use physiology::{Compartment, SimulationError};

/// Errors of twins, their training, files and evaluation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TwinError {
    /// A quantity that must be a finite number is not.
    #[error("{0} is not a finite number; check the record it came from")]
    NotFinite(&'static str),
    /// A weight of the tensor of this name is not a finite number.
    #[error("tensor {0} holds a value that is not a finite number; train or import it anew")]
    NotFiniteWeight(String),
    /// A tensor has the wrong number of values.
    #[error("tensor {tensor} has {found} values, {expected} expected for 10-128-64-32-1")]
    Shape {
        /// The tensor's name in the file.
        tensor: String,
        /// Values found.
        found: usize,
        /// Values expected.
        expected: usize,
    },
    /// The tensor of this name is absent.
    #[error("tensor {0} is missing; is this the file of a twin?")]
    MissingTensor(String),
    /// The population model lets glucose reach a compartment that must not depend on it.
    #[error(
        "network {compartment} of the population model sees {glucose}; a twin needs a population \
         model in which only Q1 and Q2 depend on glucose"
    )]
    Wiring {
        /// The network at fault.
        compartment: Compartment,
        /// The glucose compartment it sees.
        glucose: Compartment,
    },
    /// The parts of a window do not fit together.
    #[error("a window of {steps} steps has {glucose} glucose values; one more than steps needed")]
    Window {
        /// Steps of inputs.
        steps: usize,
        /// Glucose values.
        glucose: usize,
    },
    /// Windows of one training set differ in length.
    #[error("training windows of {first} and {other} steps; all must have the same length")]
    UnequalWindows {
        /// Steps of the first window.
        first: usize,
        /// Steps of a window that differs.
        other: usize,
    },
    /// Runs that are simulated together differ in number or length.
    #[error(
        "runs simulated together need one start each and as many inputs: {expected} expected, {found} found"
    )]
    UnequalRuns {
        /// Starts, or steps of the first run.
        expected: usize,
        /// Lists of inputs, or steps of a run that differs.
        found: usize,
    },
    /// There is nothing to train on.
    #[error("no training windows; exclude the person or allow shorter windows")]
    NoWindows,
    /// A training setting cannot be.
    #[error("training setting {setting} is {value}; it must be {requirement}")]
    Setting {
        /// The setting's name.
        setting: &'static str,
        /// Its value.
        value: f64,
        /// What would be accepted.
        requirement: &'static str,
    },
    /// The loss left the finite numbers in an epoch, counted from 0.
    #[error("loss is not a finite number in epoch {0}; lower the learning rate")]
    Diverged(usize),
    /// A weight file holds something else than a twin: what its metadata and tensors suggest.
    #[error("no twin in this file, it holds {0}; give a file that `twin` or `import-model` wrote")]
    WrongKind(String),
    /// The description of a twin in its file is unreadable; what is wrong with it.
    #[error("description of the twin in the file: {0}; write the file anew")]
    Header(String),
    /// A twin was trained on another population model.
    #[error(
        "twin was trained on the population model {expected}, this one is {found}; give the \
         population model it was trained on"
    )]
    OtherPopulation {
        /// Hash the twin's file names.
        expected: String,
        /// Hash of the model that was given.
        found: String,
    },
    /// A weight file cannot be parsed; what the parser said.
    #[error("not a readable safetensors file: {0}; it may be truncated, write it anew")]
    File(String),
    /// A window needs a sensor reading that is not there.
    #[error("person '{person}', step {step}: no sensor reading; choose windows with every reading")]
    NoReading {
        /// The person's identifier.
        person: String,
        /// The step of the record.
        step: usize,
    },
    /// A twin is another person's.
    #[error("person '{person}' cannot go on from the twin of '{twin}'; give their own twin")]
    OtherPerson {
        /// The person whose record was given.
        person: String,
        /// The person whom the twin stands for.
        twin: String,
    },
    /// A twin was trained on days that are to test now.
    #[error(
        "the earlier twin was trained on the first {seen} days, and only {days} are to train now: it would be \
             tested on days that trained it; give --training-days {seen} or more"
    )]
    SeenDays {
        /// Days that trained the twin.
        seen: usize,
        /// Days that are to train.
        days: usize,
    },
    /// The record.
    #[error(transparent)]
    Cohort(Box<CohortError>),
    /// The population model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A simulation stopped.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A simulation of this person's record failed.
    #[error("person '{person}': {source}")]
    OfPerson {
        /// The person's identifier.
        person: String,
        /// What failed.
        source: SimulationError,
    },
    /// The ODE plant.
    #[error(transparent)]
    Ode(#[from] OdeError),
}

impl From<CohortError> for TwinError {
    fn from(error: CohortError) -> Self {
        Self::Cohort(Box::new(error))
    }
}

impl TwinError {
    /// The same error with the person's name where a failed simulation does not tell it.
    pub(crate) fn of_person(self, person: &str) -> Self {
        match self {
            Self::Simulation(source) => Self::OfPerson { person: person.to_owned(), source },
            named => named,
        }
    }
}
