//! Where a plant misses a cohort.

pub mod augmented;
pub mod calibration;
pub mod context;
pub mod covariance;
mod error;
pub mod filter;
pub mod free_run;
pub mod noise;
pub mod observations;
pub mod whitening;

pub use error::GapError;
pub use noise::NoiseModel;
pub use observations::{MissingDosePolicy, Observations, Reading};
