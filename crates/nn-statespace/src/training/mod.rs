//! Training of the population model by simulation error (paper, section "Model training").
//!
//! Windows of simulated days are rolled out from their first state by Forward Euler, and the
//! whole roll-out is compared with the simulation: [`WindowSet`] holds the data, [`RollOut`] is
//! the computation as a plain candle graph, [`loss`] compares, [`train`] is the loop.

mod config;
mod epoch;
mod initial_weights;
pub mod loss;
mod loss_terms;
mod roll_out;
mod train;
mod validation;
pub(crate) mod windows;

pub use config::{GradientLimit, KeptWeights, LearningRate, Stage, TrainingConfig};
pub use epoch::EpochReport;
pub use initial_weights::initial_networks;
pub use loss_terms::LossTerms;
pub use roll_out::RollOut;
pub use train::{Provenance, Trained, TrainingReport, train};
pub use validation::{GroupErrors, WindowGroup, validate};
pub use windows::{CarbStart, Run, WindowSet};
