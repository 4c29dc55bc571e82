//! Where a simulation starts when only the first glucose value is known.
//!
//! The paper assumes a steady state (section "Estimating initial states"). [`steady_state`] solves
//! for one; [`InitialStateTable`] reads the table that the authors computed with stochastic
//! gradient descent, whose rows are not quite steady states but are needed to reproduce them.

mod steady_state;
mod table;

pub use steady_state::{StartCheck, SteadyState, SteadyStateOutcome, check_start, steady_state};
pub use table::InitialStateTable;
