//! Where a simulation starts when only the first glucose value is known.
//!
//! The paper assumes a steady state (section "Estimating initial states"). [`steady_state`] solves
//! for one; [`InitialStateTable`] reads the table that the authors computed with stochastic
//! gradient descent, whose rows are not quite steady states but are needed to reproduce them.

mod check;
mod steady_state;
mod table;

pub use check::{StartCheck, check_start};
pub use steady_state::{SteadyState, SteadyStateOutcome, steady_state};
pub use table::InitialStateTable;
