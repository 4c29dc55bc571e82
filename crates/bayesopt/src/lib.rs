//! Bayesian optimisation: where to evaluate an expensive function next to find its minimum.
//!
//! A [`latin_hypercube`] spreads the first points. [`propose`] then fits a Gaussian process to the
//! values so far and weighs the expected improvement (Jones, Schonlau and Welch 1998) against the
//! expected value. Both follow from their arguments alone; the caller evaluates the function.
//!
//! ```
//! use bayesopt::{Range, latin_hypercube, propose};
//!
//! let ranges = [Range::new(-1.0, 4.0)?, Range::new(0.0, 3.0)?];
//! let bowl = |x: &[f64]| (x[0] - 1.0).powi(2) + (x[1] - 2.0).powi(2);
//! let mut tried: Vec<(Vec<f64>, f64)> = latin_hypercube(&ranges, 8, 1)
//!     .into_iter()
//!     .map(|point| { let value = bowl(&point); (point, value) })
//!     .collect();
//! for seed in 0..8 {
//!     let point = propose(&tried, &ranges, seed)?;
//!     let value = bowl(&point);
//!     tried.push((point, value));
//! }
//! assert!(tried.iter().any(|(_, value)| *value < 0.05));
//! # Ok::<(), bayesopt::SearchError>(())
//! ```
//!
//! Research software. Not a medical device; not validated for any treatment decision.

mod error;
mod gaussian_process;
mod hypercube;
mod improvement;
mod pattern_search;
mod range;

pub use error::SearchError;
pub use hypercube::latin_hypercube;
pub use improvement::propose;
pub use range::Range;
