//! The stages from a study's files to the report: each takes settings, calls the crates, and writes one folder that is
//! complete or absent, with a manifest of what it was made from.
//!
//! A stage is a module of [`stages`] with its `Settings` and its `run`. This crate opens files for the user and tells of
//! progress; it knows no command line.
//!
//! ```
//! use pipeline::Manifest;
//! use pipeline::stages::reconcile::{DetectorName, Rule, Settings, run};
//!
//! pipeline::be_quiet();
//! let cohort = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/embedded/cohort");
//! let folder = tempfile::tempdir()?;
//! let out = folder.path().join("reconciled");
//! let (detector, rule) = (DetectorName::Grid, Rule::Additive);
//! run(&Settings { cohort: cohort.into(), detector, rule, out: out.clone() })?;
//! let manifest = Manifest::read(&out).expect("a finished folder has one");
//! assert_eq!(manifest.stage, "reconcile");
//! assert!(manifest.outputs.iter().any(|file| file.path == "records.parquet"));
//! # anyhow::Ok(())
//! ```

mod asked;
pub mod bounds;
mod checkpoint;
mod conformance_text;
mod diagnosed;
mod files;
mod hidden_folder;
mod interrupt;
mod labels;
mod lock;
mod manifest;
mod next_step;
mod output;
mod paper_conformance;
pub mod people;
mod profile;
mod progress;
mod result_file;
pub mod stages;
mod stated_truth;
mod subnetworks;
mod tidy;
mod unseen;
pub mod usage;

pub use manifest::{Manifest, call_program};
pub use next_step::say_next;
pub use output::OutputFolder;
pub use profile::Profile;
pub use progress::{Progress, ask_for_json, be_quiet, in_words, note, say, table};
pub use result_file::result_file;

/// The folder of the workspace's `Cargo.toml` when this program was built.
#[must_use]
pub fn workspace_root() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}
