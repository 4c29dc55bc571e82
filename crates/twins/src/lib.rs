//! Digital twins: the population model with one person's own network added to it.
//!
//! A [`Twin`] is the neural state-space population model plus a residual network that sees the
//! states around glucose and the person's context (heart rate, sleep, weekend, hour) and adds to
//! dQ1/dt inside the simulation loop (Roquemen-Echeverri et al., section "Individual-level model";
//! the *paper* in this workspace). The crate trains such networks ([`build_twins`]), keeps them in
//! files ([`Twin::to_bytes`]), reads those that the paper's authors published
//! ([`published_twin`]) and runs records through them ([`replay()`]).
//!
//! An untrained twin is the population model, exactly:
//!
//! ```
//! use twins::{INPUTS, ResidualNetwork};
//!
//! let network = ResidualNetwork::untrained(42);
//! assert_eq!(network.evaluate(&[0.5; INPUTS]), 0.0);
//! ```
//!
//! A twin of one person, trained for an epoch:
//!
//! ```
//! use std::sync::Arc;
//!
//! use nn_statespace::PopulationModel;
//! use twins::{Doses, InputSet, Protocol, TrainingPlan, TwinRecipe, build_twins};
//!
//! let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/embedded/cohort");
//! let mut cohort = cohort::read_folder(folder.as_ref())?;
//! cohort.people.truncate(1);
//! let recipe = TwinRecipe {
//!     population: Arc::new(PopulationModel::shipped()?),
//!     protocol: Protocol::quick(),
//!     plan: TrainingPlan { epochs: 1, ..TrainingPlan::quick() },
//!     inputs: InputSet::All,
//!     doses: Doses::Population,
//!     seed: 1,
//! };
//! let twins = build_twins(&cohort, &recipe, &|_| ())?;
//! assert!(twins[0].result.is_ok());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The crate opens no files and prints nothing; randomness comes from explicit seeds.

// The synthetic people of the tests name this crate.
#[cfg(test)]
extern crate self as twins;

mod cohort_training;
mod error;
mod file;
mod fingerprint;
mod gains;
#[cfg(test)]
mod graph;
mod heart_rate;
mod import;
mod inputs;
mod loss;
mod prepared;
mod protocol;
mod replay;
mod residual;
mod roll_out;
mod signs;
mod start;
#[cfg(test)]
#[expect(dead_code, reason = "other tests use the rest of this module")]
#[path = "../tests/it/synthetic.rs"]
mod synthetic;
mod training;
mod twin;

pub use cohort_training::{
    BuiltTwin, PersonTwin, TwinRecipe, build_twin, build_twins, build_twins_from,
};
pub use error::TwinError;
pub use file::is_twin;
pub use fingerprint::{population_fingerprint, windows_fingerprint};
pub use gains::Doses;
pub use heart_rate::HeartRateScaler;
pub use import::published_twin;
pub use inputs::{INPUT_NAMES, INPUTS, InputSet, MissingContext, PERSONAL_INPUTS, STATE_INPUTS};
pub use loss::{HIGH, LOW, Penalty, ScaledLoss, TwinLoss};
pub use prepared::{Known, PreparedWindow};
pub use protocol::{Exclusion, HeldOut, Part, PersonWindows, Protocol, inputs_within, measured};
pub use replay::{ReplayRow, ReplayStart, replay};
pub use residual::{HIDDEN, PARAMETERS, ResidualNetwork};
pub use roll_out::simulate_many;
pub use signs::Signs;
pub use start::{
    Startable, Starts, SteadyStates, WindowStart, settled, window_starts, window_starts_with,
};
pub use training::{Epoch, KeptEpoch, Trained, TrainingPlan, train, window_courses, window_loss};
pub use twin::{Twin, TwinCard};
