//! Whether a model of glucose answers to insulin and carbohydrate as a person does.
//!
//! A model that fits recorded days may still settle at a healthy glucose without insulin, or rise after a bolus:
//! such inputs are rare in records. These checks run any [`Plant`](physiology::Plant) freely, from rest at several
//! glucose values, up a ladder of doses, beside a reference that is known to behave (the ODE). Each passes or fails
//! with its worst case.
//!
//! | check | asks |
//! |---|---|
//! | [`Check::ZeroInsulin`] | a day without insulin ends in hyperglycaemia |
//! | [`Check::Basal`] | more basal never ends higher after a day |
//! | [`Check::Bolus`] | a larger bolus without food never raises glucose, at any time, by more than in the reference |
//! | [`Check::Carbs`] | more carbohydrate never lowers it by more than in the reference |
//! | [`Check::CarbRatio`] | a meal with more insulin a gram never stays higher, by more than in the reference |
//!
//! ```
//! use behaviour::{CheckRule, Rest, Subject, check};
//! use ode_sim::{OdeParameters, OdePlant, steady_state};
//! use physiology::Kilograms;
//!
//! let (parameters, weight) = (OdeParameters::nominal(), Kilograms(76.3));
//! let plant = OdePlant::reproduction(parameters, weight);
//! let rest = |glucose| {
//!     let found = steady_state::at_glucose(&parameters, weight, glucose)
//!         .map_err(|error| error.to_string())?;
//!     Ok(Rest { state: found.state, basal: found.basal, is_steady: true })
//! };
//! let ode = Subject { plant: &plant, rest: &rest };
//! let report = check(&ode, &ode, &CheckRule::working())?;
//! assert!(report.passed);
//! # Ok::<(), behaviour::BehaviourError>(())
//! ```

mod error;
mod ladder;

pub use contract::trajectories::{Check, Finding, Rung, Trajectories, WorstCase};
pub use error::BehaviourError;
pub use ladder::{CheckRule, Rest, Subject, check};
