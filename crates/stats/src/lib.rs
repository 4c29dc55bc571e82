//! Glycaemic outcomes, paired equivalence tests, person-level bootstrap and multiplicity.
//!
//! Follows the section "Statistical analysis of similarity between simulated and real-world
//! glucose outcomes" of Roquemen-Echeverri et al., and adds what the paper leaves out: intervals
//! beside every estimate, resampling by person, and adjustment for the number of questions asked.
//! The crate reads no files, prints nothing, and draws random numbers from explicit seeds only.
//!
//! ```
//! use physiology::MgPerDl;
//! use stats::{Outcome, Outcomes, tost};
//!
//! let window = [82.0, 120.0, 175.0, 191.0].map(MgPerDl);
//! let outcomes = Outcomes::of(window)?;
//! assert_eq!(outcomes.get(Outcome::Tir), 75.0);
//!
//! // Time in range of five people, measured and simulated, margin 5 points, level 0.05.
//! let actual = [71.0, 64.0, 80.0, 75.0, 68.0];
//! let simulated = [72.0, 63.5, 79.0, 76.5, 68.5];
//! let test = tost::paired(&actual, &simulated, Outcome::Tir.margin(), 0.05)?;
//! assert!(test.equivalent);
//! # Ok::<(), stats::StatsError>(())
//! ```

pub mod agreement;
pub mod bootstrap;
pub mod chains;
pub mod equivalence;
mod error;
mod moments;
pub mod multiplicity;
mod outcomes;
pub mod paired;
pub mod profile;
pub mod proportion;
mod quantile;
pub mod tost;
pub mod wilcoxon;

pub use agreement::{Agreement, agreement};
pub use bootstrap::{Bootstrap, Estimate, Interval, ReplicateMatrix};
pub use equivalence::compare_outcomes;
pub use error::StatsError;
pub use moments::summary;
pub use outcomes::{Outcome, Outcomes};
pub use paired::PairedComparison;
pub use quantile::{quantile, quantiles};
pub use tost::Tost;
