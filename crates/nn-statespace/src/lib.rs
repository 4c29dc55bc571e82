//! The neural state-space population model of glucose dynamics.
//!
//! Ten small networks, one a compartment, give the rates of the ten states (Roquemen-Echeverri et
//! al., section "Population-level model", Eq. 2; the *paper* in this workspace). Each network sees
//! only the signals that the corresponding differential equation sees, so that every state keeps
//! its physiological meaning. The crate holds the networks and their wiring, the robust scaler,
//! the plant that rolls them out, the loss and the training loop, the weight files, and the reader
//! of the weights that the paper's authors published.
//!
//! ```
//! use nn_statespace::PopulationModel;
//! use nn_statespace::initial_state::steady_state;
//! use physiology::{MgPerDl, OpenLoop, Plant as _, StepInput, simulate};
//!
//! let model = PopulationModel::shipped()?;
//! let held = steady_state(&model, MgPerDl(120.0))?;
//! // Half of the basal rate for three hours: glucose rises.
//! let basal = physiology::UnitsPerHour(0.5 * held.basal.0);
//! let inputs = vec![StepInput { basal, ..StepInput::default() }; 36];
//! let run = simulate(&model, held.states, &mut OpenLoop::new(&inputs), inputs.len())?;
//! let last = run.states.last().map(|state| model.glucose(state).0);
//! assert!(last > Some(125.0), "{last:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
pub mod import;
pub mod initial_state;
pub mod kernel;
mod network;
mod per_compartment;
mod population;
mod scaler;
mod signal;
pub mod structure;
pub mod training;
pub mod training_set;
mod weight_file;
mod widths;
mod wiring;

pub use error::ModelError;
pub use network::HiddenLayerNetwork;
pub use per_compartment::PerCompartment;
pub use population::{GLUCOSE_RANGE, GlucoseClamp, ModelCard, PopulationModel};
pub use scaler::{CentreAndScale, DoseGains, ScaledInputs, ScaledStates, Scaler};
pub use signal::Signal;
pub use widths::Widths;
pub use wiring::Wiring;
