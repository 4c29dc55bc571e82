//! `export`: a cohort folder in a format that other programs read.

use std::path::PathBuf;

use anyhow::{Context as _, Result};
pub use cohort::ExportFormat;
use cohort::{export, read_folder};

use crate::{Manifest, OutputFolder, note};
use ::report::count;

/// Settings of `export`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Cohort folder.
    pub cohort: PathBuf,
    /// Format to write.
    pub to: ExportFormat,
    /// Output folder.
    pub out: PathBuf,
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let cohort = read_folder(&args.cohort).context("reading the cohort")?;
    let config = serde_json::json!({ "to": args.to.name() });
    let manifest = Manifest::new("export", config, None).with_input(&args.cohort)?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    export(&cohort, args.to, output.path()).context("writing the cohort")?;
    let place = output.finish()?;
    let people = count(cohort.people.len(), "person", "people");
    note(format!("export: {people} in {}", place.display()));
    Ok(())
}
