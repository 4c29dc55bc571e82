//! The filter and what belongs to it: a person's plant, followed reading by reading, calibrated, and linear about what it
//! followed. It knows no effect by name and none of the questions that are put to it.
//!
//! [`augmented`] is the plant with a flux, a sensor and their noise ([`NoiseModel`](crate::NoiseModel)), or another
//! [`body`] in its place. [`kalman`] follows a record ([`observations`]). [`calibration`] finds a person's parameters.
//! [`tangent`] tells what a change of the model does to the innovations, [`whitening`] prepares them.

pub mod augmented;
pub mod body;
pub mod calibration;
pub mod covariance;
pub mod kalman;
pub(crate) mod noise;
pub mod observations;
pub(crate) mod plants;
pub(crate) mod scored;
pub mod state;
pub mod tangent;
pub mod transition;
pub mod whitening;
