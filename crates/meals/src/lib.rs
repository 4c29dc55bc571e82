//! Meals: found in sensor and insulin, matched against what was logged, and scored where the truth
//! is known.
//!
//! People forget to log meals, log them late, and miscount them. A digital twin that is trained on
//! such a log learns the errors as physiology. The paper therefore replaces logs by reconciled ones
//! (Roquemen-Echeverri et al., "Development dataset preprocessing" of the individual-level model).
//!
//! - [`detect`]: two detectors that look at sensor, insulin and clock and never at what was logged:
//!   the published GRID, and a matched filter behind a Kalman filter on the ODE plant.
//! - [`mod@reconcile`]: the paper's three passes over detections, reports and boluses, with the
//!   fate of every event; and a rule of ours that only adds.
//! - [`score`]: agreement with meals that are known, of detectors and of logs.
//!
//! The crate opens no files, prints nothing, draws no random numbers, and does not know how worlds
//! are made.
//!
//! ```
//! use cohort::{Channel, Person, Record, Therapy};
//! use meals::reconcile::{Fate, ReconcileSettings, Rule, reconcile};
//! use meals::{Detector, PlantSettings};
//! use ode_sim::{OdeParameters, OdePlant, steady_state};
//! use physiology::{Grams, Kilograms, MgPerDl, OpenLoop, StepInput, simulate};
//!
//! // A day of a nominal body that eats 60 g at 10:00 without a bolus and without logging it.
//! let plant = OdePlant::reproduction(OdeParameters::nominal(), Kilograms(76.3));
//! let start = steady_state::at_glucose(&plant.parameters, plant.weight, MgPerDl(120.0))?;
//! let mut inputs = vec![StepInput { basal: start.basal, ..StepInput::default() }; 288];
//! inputs[120].carbs = Grams(60.0);
//! let run = simulate(&plant, start.state, &mut OpenLoop::new(&inputs), 288)?;
//!
//! let mut record = Record::new("2024-03-08T00:00:00".parse()?, 288)?;
//! for (step, glucose) in run.glucose(&plant).iter().take(288).enumerate() {
//!     record.channel_mut(Channel::Cgm)[step] = Some(glucose.0.round());
//! }
//! record.channel_mut(Channel::Basal).fill(Some(start.basal.0));
//! record.channel_mut(Channel::Carbs).fill(Some(0.0));
//! let person = Person {
//!     id: "a".into(),
//!     weight: Some(plant.weight),
//!     therapy: Therapy::OpenLoopPump,
//!     heart_rate_baseline: None,
//!     record,
//! };
//!
//! let found = Detector::Plant(PlantSettings::working()).detect(&person)?;
//! assert_eq!(found.meals.len(), 1);
//! assert!(found.meals[0].step.abs_diff(120) <= 3);
//! let mended = reconcile(&person, &found, &ReconcileSettings::new(Rule::Additive))?;
//! assert_eq!(mended.events[0].fate, Fate::MealAdded);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod detect;
mod error;
pub mod reconcile;
pub mod score;
mod signals;

pub use detect::{Detected, Detection, Detector, GridSettings, PlantSettings};
pub use error::MealError;
pub use signals::{ASSUMED_WEIGHT, Signals};
