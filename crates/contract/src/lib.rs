//! Every JSON file that the workspace writes, as a type: once, with its units, for who writes and who reads.
//!
//! A file is read strictly: a key that is missing, unknown or of another type is an error with its line and
//! column, and so is a file of another schema. JSON Schemas are made from these types; `docs/outputs.md`
//! lists every key.
//!
//! ```
//! use contract::{ContractError, TwinsTable, read};
//!
//! let text = br#"{"schema": "twins/1", "people": []}"#;
//! let twins: TwinsTable = read(text)?;
//! assert!(twins.people.is_empty());
//!
//! let misspelt = br#"{"schema": "twins/1", "persons": []}"#;
//! assert!(matches!(read::<TwinsTable>(misspelt), Err(ContractError::Json { .. })));
//! # Ok::<(), ContractError>(())
//! ```

#[macro_use(apply)]
extern crate macro_rules_attribute;

macro_rules_attribute::attribute_alias! {
    // An object that is read strictly: no key may be missing, unknown or of another type.
    #[apply(strict!)] =
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[cfg_attr(test, derive(schemars::JsonSchema))]
        #[serde(deny_unknown_fields)];
    // One of a list of words.
    #[apply(word!)] =
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        #[cfg_attr(test, derive(schemars::JsonSchema))]
        #[serde(rename_all = "snake_case")];
}

pub mod agp;
pub mod baselines;
pub mod bench;
pub mod blind_check;
pub mod certificates;
pub mod conformance;
pub mod development_set;
pub mod diagnosis;
mod document;
mod document_kinds;
pub mod effect_twins;
mod error;
pub mod example_day;
pub mod glucose_by_person;
pub mod held_out;
pub mod import_report;
mod interval;
mod manifest;
pub mod meals;
pub mod outcomes;
pub mod posterior;
pub mod quality;
pub mod region;
pub mod repair;
pub mod run_errors;
#[cfg(test)]
mod schemas;
pub mod steady_state;
pub mod training;
pub mod trajectories;
pub mod truth;
mod twins;
pub mod what_if;
pub mod widths;

pub use agp::GlucoseProfile;
pub use baselines::Baselines;
pub use blind_check::BlindCheck;
pub use certificates::Certificates;
pub use conformance::Conformance;
pub use diagnosis::Diagnosis;
pub use document::{Document, DocumentKind, read};
pub use document_kinds::document_kinds;
pub use effect_twins::EffectTwins;
pub use error::ContractError;
pub use example_day::ExampleDay;
pub use glucose_by_person::GlucoseByPerson;
pub use held_out::HeldOut;
pub use import_report::ImportReport;
pub use interval::{Spread, Summary, WithInterval};
pub use manifest::{FileHash, Manifest};
pub use meals::Meals;
pub use outcomes::{Equivalence, Exclusions, OutcomesTable};
pub use quality::DataInUse;
pub use region::RegionFile;
pub use repair::Repair;
pub use run_errors::RunErrors;
pub use steady_state::SteadyStates;
pub use training::Training;
pub use trajectories::Trajectories;
pub use truth::StatedTruth;
pub use twins::{TwinRow, TwinsTable};
pub use what_if::WhatIf;
pub use widths::WidthSearch;
