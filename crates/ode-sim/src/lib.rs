//! The glucoregulatory ODE plant of type 1 diabetes (T1DSim_ODE): Eq. (1) of the paper, its
//! integrators, steady state, virtual people, exercise, dosing, scenarios, sensor and pump models.
//!
//! Sources: Resalat et al. 2019 (virtual population and exercise), Hovorka et al. 2004 (uptake and
//! renal clearance), Roquemen-Echeverri et al. (the *paper*). The crate touches no files.
//!
//! ```
//! use ode_sim::{OdeParameters, OdePlant, steady_state};
//! use physiology::{Grams, Kilograms, MgPerDl, OpenLoop, StepInput, simulate};
//!
//! let plant = OdePlant::reproduction(OdeParameters::nominal(), Kilograms(76.3));
//! let start = steady_state::at_glucose(&plant.parameters, plant.weight, MgPerDl(120.0))?;
//! let mut inputs = vec![StepInput { basal: start.basal, ..StepInput::default() }; 72];
//! inputs[12].carbs = Grams(40.0);
//! let run = simulate(&plant, start.state, &mut OpenLoop::new(&inputs), 72)?;
//! let glucose = run.glucose(&plant);
//! assert!((glucose[12].0 - 120.0).abs() < 1e-6);
//! assert!(glucose.iter().any(|g| g.0 > 180.0));
//! # Ok::<(), ode_sim::OdeError>(())
//! ```

pub mod development_set;
pub mod dosing;
mod dual;
pub mod equations;
mod error;
pub mod exercise;
pub mod gut;
mod integrator;
mod linearised;
pub mod meal_day;
mod parameters;
pub mod personal;
mod plant;
pub mod population;
pub mod pump;
mod random;
pub mod rescue;
pub mod sensor;
mod state;
pub mod steady_state;
pub mod vpp_scenario;

pub use development_set::{DevelopmentPlan, DevelopmentSet};
pub use dosing::BolusCalculator;
pub use dual::{Dual, Scalar};
pub use equations::EgpMode;
pub use error::OdeError;
pub use exercise::ExerciseMemory;
pub use gut::GutPair;
pub use integrator::Integrator;
pub use parameters::{OdeParameters, T1D_SENSITIVITY_FACTOR};
pub use personal::PersonalFactors;
pub use plant::OdePlant;
pub use population::{VirtualPerson, population};
pub use pump::Pump;
pub use rescue::RescueCarbs;
pub use sensor::{Sensor, SensorModel};
pub use state::{OdeMatrix, OdeState, OdeVector, slot};
pub use steady_state::SteadyState;
