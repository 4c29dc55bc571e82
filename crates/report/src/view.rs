//! The JSON files as the report reads them.
//!
//! These structs are the report's own view of the contract: keys that it does not know are
//! ignored, and a number that JSON cannot hold (NaN, infinity) arrives as null and is shown as
//! absent.

mod agp;
mod blind_check;
mod conformance;
mod diagnosis;
mod example_day;
mod lenient;
mod manifest;
mod outcomes;
mod seal;
mod training;
mod twins;
mod what_if;

pub use agp::{Agp, Percentiles};
pub use blind_check::{
    BlindCheck, Confusion, ConfusionRow, NamedEffect, Pairs, PowerRow, Reliability, ReliabilityBin,
    Share, Target, TrueEffect, UnknownScore, World,
};
pub use conformance::{Conformance, ConformanceRow, Counterexample, FailingShare, Slice, Verdict};
pub use diagnosis::{
    Absorbed, AbsorbedEffect, AbsorbedError, Candidate, CellGap, CoursePart, DataQualityFinding,
    DetectionPower, Diagnosis, DiagnosisPerson, DiagnosisVerdict, Effect, FindingEstimate,
    FittedAmplitude, HorizonChange, HorizonError, HowFar, InnovationChange, OutcomeChange,
    PersonAmplitude, PersonChange, PortEvidence, PosteriorSaid, Untried,
};
pub use example_day::{DayOutcomes, ExampleDay, TimeInRanges};
pub use manifest::{Manifest, ManifestInput};
pub use outcomes::{
    Comparison, Exclusion, ForecastRow, IntervalMethod, Method, OutcomeRow, Outcomes,
    ScenarioOutcomes,
};
pub use seal::{Seal, SealedWorld};
use serde::Deserialize;
pub use training::{Epoch, Training, TrainingData};
pub use twins::{TwinPerson, Twins};
pub use what_if::{WhatIf, WhatIfCurve, WhatIfOrder, WhatIfPlan};

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

/// A number with the ends of its interval, any of which may be absent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Range {
    /// The estimate.
    pub value: Option<f64>,
    /// Lower end.
    pub lower: Option<f64>,
    /// Upper end.
    pub upper: Option<f64>,
}

impl Range {
    /// The three numbers, if all are there.
    #[must_use]
    pub fn whole(self) -> Option<WithInterval> {
        Some(WithInterval { value: self.value?, lower: self.lower?, upper: self.upper? })
    }
}
