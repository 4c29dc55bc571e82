//! The sim-to-real gap of a cohort: where a plant misses, which effect it lacks, how far adding it goes.
//!
//! Doubtful data come first ([`quality`]). Each person is then followed by an extended Kalman filter on
//! the ODE plant, or on another [`Body`], and calibrated by maximum a posteriori ([`filter`], [`calibration`](filter::calibration)).
//!
//! - *Where*: free runs from filtered states ([`free_run`]) and whitened innovations ([`whitening`](filter::whitening)) are
//!   averaged by situation ([`context`]), with simultaneous intervals over people ([`localisation`]).
//! - *Which*: what every effect of the library would do to the innovations ([`tangent`](filter::tangent), [`design`]) is
//!   weighed against a background that any two bodies may differ in, on days held out ([`mod@which`]).
//! - *How far*: held-out error before and after the effects found are added ([`how_far`]).
//!
//! A [`Diagnoser`] does all of it and returns a [`Diagnosis`] in the layout of `diagnosis.json`. Its verdict
//! is "effect", "unknown" (something varies that the library does not hold) or "none" (nothing that
//! the data could show).
//!
//! ```no_run
//! use gap::{Diagnoser, DiagnosisConfig};
//!
//! let cohort = cohort::read_folder("my-cohort".as_ref())?;
//! let config = DiagnosisConfig::working();
//! let diagnosis = Diagnoser::new(&effects::library(), &config).run(&cohort, 1)?;
//! for found in &diagnosis.effects {
//!     assert!(found.probability <= 1.0 && found.amplitude.lower >= 0.0);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Every error is observed minus predicted: positive where the plant under-predicts glucose.
//!
//! Research software. Not a medical device; not validated for any treatment decision.

mod absorbed;
mod background;
mod belief;
mod calibrated_person;
mod cell_sample;
mod cohort_statistics;
mod config;
pub mod context;
mod course;
pub mod design;
mod diagnose;
mod error;
mod event_bank;
mod expected_gap;
mod f32_kernels;
pub mod filter;
pub mod free_run;
mod free_run_statistics;
mod hourly;
pub mod how_far;
pub mod localisation;
mod log_sum;
mod misfit;
mod moderation;
mod modulated_plant;
mod person;
mod person_statistics;
pub mod quality;
mod questioned;
mod statistics;
mod track_record;
pub mod undone;
mod units;
pub mod which;

pub use absorbed::absorbed;
pub use belief::working_posterior;
pub use calibrated_person::CalibratedPerson;
pub use config::{DiagnosisConfig, InclusionRule};
pub use contract::diagnosis;
pub use contract::diagnosis::{Absorbed, Evidence, PersonSummary, Verdict};
pub use course::course;
pub use diagnose::Diagnoser;
pub use error::GapError;
pub use filter::body::Body;
pub use filter::calibration::CalibrationRule;
pub use filter::noise::NoiseModel;
pub use filter::observations::{MissingDosePolicy, Observations, Reading};
pub use filter::plants::{Ode, Plants};
pub use free_run::FreeRunRule;
pub use localisation::LocalisationRule;
pub use modulated_plant::{ModulatedPlant, ModulatedState};
pub use statistics::{PersonStatistics, cohort_statistics, person_statistics};
pub use track_record::{Counted, TrackRecord};
pub use which::ceiling;
pub use which::{FirstRound, Which, first_round, which};

/// A diagnosis with the settings of this crate: `diagnosis.json`.
pub type Diagnosis = contract::Diagnosis<DiagnosisConfig>;
