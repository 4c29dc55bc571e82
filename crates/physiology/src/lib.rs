//! What every plant of the workspace shares: units, compartments, the inputs of one five-minute
//! step, the [`Plant`] trait and the one simulation loop.
//!
//! The vocabulary follows Roquemen-Echeverri et al., "A Physiologically-Constrained Neural Network
//! Digital Twin Framework for Replicating Glucose Dynamics in Type 1 Diabetes" (the *paper* in
//! this workspace). The crate does no input or output and depends on nothing but its error type and
//! the macro for its enumerations.
//!
//! ```
//! use physiology::{Compartment, MgPerDl, OpenLoop, Plant, States, StepInput, simulate};
//!
//! /// Glucose that relaxes to 100 mg/dL, whatever is given.
//! struct Relaxing;
//! impl Plant for Relaxing {
//!     type State = f64;
//!     fn step(&self, x: &f64, _: &StepInput) -> Result<f64, physiology::NonFinite> {
//!         Ok(x + 0.1 * (100.0 - x))
//!     }
//!     fn glucose(&self, x: &f64) -> MgPerDl {
//!         MgPerDl(*x)
//!     }
//!     fn report(&self, x: &f64) -> States {
//!         let mut states = States::default();
//!         states[Compartment::Q1] = *x;
//!         states
//!     }
//! }
//!
//! let inputs = vec![StepInput::default(); 24];
//! let trajectory = simulate(&Relaxing, 160.0, &mut OpenLoop::new(&inputs), 24)?;
//! assert_eq!(trajectory.states.len(), 25);
//! assert!(trajectory.glucose(&Relaxing).last().is_some_and(|g| g.0 < 110.0));
//! # Ok::<(), physiology::SimulationError>(())
//! ```

mod compartment;
mod input;
mod plant;
mod simulation;
mod units;

pub use compartment::{Compartment, States};
pub use input::{Context, Exercise, FastCarbs, STEP, STEPS_PER_DAY, STEPS_PER_HOUR, StepInput};
pub use plant::{NonFinite, Plant};
pub use simulation::{InputSource, OpenLoop, SimulationError, Trajectory, simulate};
pub use units::{
    BeatsPerMinute, GRAMS_PER_MMOL_GLUCOSE, Grams, GramsPerUnit, Kilograms,
    MG_PER_DL_PER_MMOL_PER_L, MgPerDl, Minutes, MmolPerL, Units, UnitsPerHour,
};
