//! Training of the population model by simulation error (paper, section "Model training").
//!
//! Windows of simulated days are rolled out from their first state by Forward Euler, and the
//! whole roll-out is compared with the simulation. [`WindowSet`] holds the data, the
//! [kernel](crate::kernel) rolls out and carries slopes back, [`LossTerms`] compares, and
//! [`TrainingRun`] is the loop, which can be stopped and taken up again; [`train`] runs it to its end.
//! [`RollOut`] and [`loss`] are the same computation as a plain candle graph, the oracle of both.

mod adam;
mod checkpoint;
mod config;
mod initial_weights;
pub mod loss;
mod loss_terms;
mod report;
mod roll_out;
mod run;
mod slope_constraints;
mod validation;
pub(crate) mod windows;

pub use crate::training_set::WindowSet;
pub use adam::Adam;
pub use config::{EarlyStop, GradientLimit, KeptWeights, LearningRate, Stage, TrainingConfig};
pub use initial_weights::initial_networks;
pub use loss_terms::LossTerms;
pub use report::{EpochReport, Provenance, Trained, TrainingReport};
pub use roll_out::RollOut;
pub use run::{Advance, TrainingRun, train};
pub use slope_constraints::{ProductPenalty, SlopeRule};
pub use validation::{GroupErrors, WindowGroup, validate};
pub use windows::{CarbStart, Run};
