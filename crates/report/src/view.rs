//! The JSON files as the report reads them.
//!
//! These structs are the report's own view of the contract: keys that it does not know are
//! ignored, and a number that JSON cannot hold (NaN, infinity) arrives as null and is shown as
//! absent.

mod agp;
mod conformance;
mod diagnosis;
mod example_day;
mod manifest;
mod outcomes;
mod training;
mod twins;

pub use agp::{Agp, Percentiles};
pub use conformance::{Conformance, ConformanceRow, Verdict};
pub use diagnosis::{
    Candidate, CellGap, DataQualityFinding, Diagnosis, DiagnosisPerson, DiagnosisVerdict, Effect,
    FindingEstimate, HorizonChange, HorizonError, HowFar, OutcomeChange, PortEvidence,
};
pub use example_day::ExampleDay;
pub use manifest::{Manifest, ManifestInput};
pub use outcomes::{
    Comparison, Exclusion, ForecastRow, IntervalMethod, Method, OutcomeRow, Outcomes,
};
use serde::Deserialize;
pub use training::{Epoch, Training, TrainingData};
pub use twins::{TwinPerson, Twins};

/// Mean and SD over people.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Sample standard deviation; absent for one person.
    pub sd: Option<f64>,
}

/// A number with the ends of its interval.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct WithInterval {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}
