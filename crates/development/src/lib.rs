//! The simulated development set as the population network needs it.
//!
//! - [`weeks`]: weeks of the set as they are stored, hashed and trained on, and the check that subsets share no day.
//! - [`TrainingData`]: windows for fitting and for stopping.
//! - [`held_out`]: population networks on held-out days beside the ODE.
//! - [`SimulatedSteps`]: what the networks see at simulated steps, and how little a signal can change.
//! - [`TrajectoryCost`]: what a change of one sub-network does to simulated glucose, the cost of a repair.
//! - [`width_search`]: which hidden widths to try next.
//!
//! It brings the simulated days of the ODE to the network.
//!
//! ```
//! use development::weeks::{check_split, simulated};
//! use ode_sim::{DevelopmentPlan, DevelopmentSet};
//!
//! let set = DevelopmentSet::new(DevelopmentPlan::quick(1))?;
//! let (facts, _rows) = simulated(&set, 0)?;
//! assert_eq!(facts.index, 0);
//! check_split(&set, &[facts])?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
pub mod held_out;
mod simulated_steps;
mod training_data;
mod trajectory_cost;
pub mod weeks;
pub mod width_search;

pub use error::DevelopmentError;
pub use simulated_steps::SimulatedSteps;
pub use training_data::TrainingData;
pub use trajectory_cost::{TrajectoryCost, WEEKS, drawn_weeks, with_network};
