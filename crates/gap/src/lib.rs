//! Where a plant misses a cohort: the sim-to-real gap by situation.
//!
//! Each person is followed by an extended Kalman filter on the ODE plant and calibrated by maximum
//! a posteriori ([`filter`], [`calibration`]). Two kinds of error are then averaged by situation
//! ([`context`]): free runs from filtered states ([`free_run`]) and whitened innovations
//! ([`whitening`]). Means carry simultaneous intervals over people and family-wise p-values
//! ([`localisation`]). [`diagnose`] does all of it and returns a [`Diagnosis`] in the layout of
//! `diagnosis.json`.
//!
//! This is the stage "where". It names no effect: its verdict is "none" (no situation shows a gap)
//! or "unknown" (some do, and nothing was tried that could explain it).
//!
//! ```no_run
//! use gap::{DiagnosisConfig, Verdict, diagnose};
//!
//! let cohort = cohort::read_folder("my-cohort".as_ref())?;
//! let diagnosis = diagnose(&cohort, &DiagnosisConfig::working(), 1)?;
//! if diagnosis.verdict == Verdict::Unknown {
//!     let largest = &diagnosis.cells[0];
//!     assert!(largest.lower <= largest.mean_error_mg_dl);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Every error is observed minus predicted: positive where the plant under-predicts glucose.
//!
//! Research software. Not a medical device; not validated for any treatment decision.

pub mod augmented;
mod background;
pub mod calibration;
mod cell_sample;
mod config;
pub mod context;
mod course;
pub mod covariance;
pub mod design;
mod diagnose;
pub mod diagnosis;
mod error;
pub mod filter;
pub mod free_run;
pub mod how_far;
pub mod localisation;
mod moderation;
mod noise;
pub mod observations;
mod person;
pub mod quality;
pub mod tangent;
pub mod which;
pub mod whitening;

pub use calibration::CalibrationRule;
pub use config::{DiagnosisConfig, InclusionRule, Production};
pub use diagnose::{diagnose, diagnose_with_progress};
pub use diagnosis::{Diagnosis, PersonSummary, Stage, Verdict};
pub use error::GapError;
pub use free_run::FreeRunRule;
pub use localisation::LocalisationRule;
pub use noise::NoiseModel;
pub use observations::{MissingDosePolicy, Observations, Reading};
pub use which::{Evidence, Threshold, Thresholds, Which, which};
