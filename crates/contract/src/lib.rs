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

pub mod agp;
pub mod blind_check;
pub mod conformance;
pub mod diagnosis;
mod document;
mod error;
pub mod example_day;
mod interval;
mod manifest;
pub mod outcomes;
pub mod quality;
#[cfg(test)]
mod schemas;
pub mod training;
mod twins;
pub mod what_if;

pub use agp::GlucoseProfile;
pub use blind_check::BlindCheck;
pub use conformance::Conformance;
pub use diagnosis::Diagnosis;
pub use document::{Document, read};
pub use error::ContractError;
pub use example_day::ExampleDay;
pub use interval::{Spread, WithInterval};
pub use manifest::{FileHash, Manifest};
pub use outcomes::OutcomesTable;
pub use quality::DataInUse;
pub use training::Training;
pub use twins::{TwinRow, TwinsTable};
pub use what_if::WhatIf;
