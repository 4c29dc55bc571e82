//! Twins and what they are compared with, against days that trained none of them.
//!
//! Follows the paper's sections "Evaluation of simulation accuracy" and "Additional experiments", and
//! adds what these leave out: intervals over people beside every difference, adjustment for the
//! number of tests, paired comparisons with the twin, forecasts that a sensor alone can make, and a
//! check of the order of what-if curves.
//!
//! - [`evaluate()`]: five-hour windows under every [`Method`], [outcomes](outcomes_table) with equivalence
//!   tests, [scenarios](Scenario), forecasts beside [autoregression](Forecaster);
//! - [`example_day()`], [`glucose_profile()`]: courses to be drawn, measured and simulated;
//! - [`glucose_by_person()`]: what a report on CGM says of each person;
//! - [`what_if()`]: meals under several doses, and whether each twin answers in the right order.
//!
//! Every method runs freely from a window's first reading; what it is judged on is what a sensor
//! would have read. People, not windows, are the unit of every mean, test and interval.
//!
//! ```
//! use evaluation::Method;
//!
//! assert_eq!(Method::Twin.name(), "twin");
//! assert!(Method::BASELINES.contains(&Method::Closest));
//! ```
//!
//! The crate opens no files and prints nothing.

mod arx;
mod error;
mod evaluate;
mod example_day;
mod forecast;
mod glucose_profile;
mod method;
mod models;
mod person;
mod readings;
mod scenario;
mod settings;
mod spread;
mod tables;
mod what_if;

pub use error::EvaluationError;
pub use evaluate::{Evaluation, evaluate};
pub use example_day::example_day;
pub use forecast::{FORECAST_MINUTES, ForecastError, Forecaster};
pub use glucose_profile::{glucose_by_person, glucose_profile};
pub use method::Method;
pub use models::{Model, PersonModels};
pub use person::{MethodResult, PersonEvaluation, ScenarioEvaluation};
pub use scenario::Scenario;
pub use settings::{EvaluationSettings, ode_baseline};
pub use spread::{HeldOutRun, drawn_course, held_out_runs, run_error, run_errors_by_person};
pub use tables::{outcomes_table, twins_table};
pub use what_if::{paper_plan, what_if};
