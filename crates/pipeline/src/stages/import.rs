//! `import`: a study's files as a cohort folder, with an account of what was done.

use std::path::PathBuf;

use anyhow::{Context as _, Result, bail};
pub use cohort::ImportFormat;
use cohort::{RecordsFormat, import, write_folder};
use contract::{Document as _, ImportReport};

use crate::manifest::Manifest;
use crate::output::OutputFolder;
use crate::progress::note;

/// Settings of `import`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Format of the source.
    pub from: ImportFormat,
    /// The study's folder or file.
    pub source: PathBuf,
    /// Output folder.
    pub out: PathBuf,
    /// Write `records.parquet` in place of `records.csv`.
    pub parquet: bool,
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    if !args.source.exists() {
        bail!("there is nothing at '{}'", args.source.display());
    }
    let (format, source) = (args.from, args.source.display());
    let imported = import(format, &args.source)
        .with_context(|| format!("importing '{source}' as {}", format.name()))?;
    let records = if args.parquet { RecordsFormat::Parquet } else { RecordsFormat::Csv };
    let config = serde_json::json!({ "from": format.name(), "parquet": args.parquet });
    let manifest = Manifest::new("import", config, None).with_input(&args.source)?;

    let output = OutputFolder::begin(&args.out, manifest)?;
    write_folder(&imported.cohort, output.path(), records).context("writing the cohort")?;
    output.write_document(&imported.report)?;
    let place = output.finish()?;
    imported.report.lines().for_each(note);
    for inference in imported.report.inferences.iter().flatten() {
        note(format!("inferred: {inference}"));
    }
    let findings: usize = imported.report.people.iter().map(|p| p.findings.len()).sum();
    note(format!(
        "import: {} people, {} notes and {findings} findings in {}",
        imported.cohort.people.len(),
        imported.report.notes.len(),
        place.join(ImportReport::FILE).display()
    ));
    Ok(())
}
