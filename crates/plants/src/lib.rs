//! What can stand in place of the ODE: the population network and a person's twin.
//!
//! [`NetworkBody`] and [`TwinBody`] are bodies inside the diagnosis' filter. [`ModulatedNetwork`] is the population network
//! under the modulations of effects, which makes a named effect an input of twins (decision 0024); [`effect_twins`] judges
//! such twins beside others.
//!
//! ```
//! use std::sync::Arc;
//!
//! use gap::Body as _;
//! use nn_statespace::PopulationModel;
//! use physiology::{Compartment, States, StepInput};
//! use plants::{NetworkBody, check_wiring};
//!
//! let model = Arc::new(PopulationModel::shipped()?);
//! check_wiring(&model)?;
//! let body = NetworkBody(model);
//! let rate = body.rate(Compartment::S1, &States::default(), &StepInput::default());
//! assert!(rate.is_finite());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bodies;
pub mod effect_twins;
mod error;
mod modulated_network;

pub use bodies::{NetworkBody, TwinBody, check_wiring};
pub use error::PlantsError;
pub use modulated_network::{Acting, Active, ModulatedNetwork, cannot_be_input, course_of};
