//! `import`: a study's files as a cohort folder, with an account of what was done.

use anyhow::{Context as _, Result, bail};
use cohort::{ImportFormat, RecordsFormat, import, write_folder};

use crate::cli::{CohortFormat, ImportArgs};
use crate::manifest::Manifest;
use crate::output::OutputFolder;
use crate::progress::note;

/// Runs the command.
pub(crate) fn run(args: &ImportArgs) -> Result<()> {
    if !args.source.exists() {
        bail!("there is nothing at '{}'", args.source.display());
    }
    let format = match args.from {
        CohortFormat::HupaUcm => ImportFormat::HupaUcm,
        CohortFormat::T1dUom => ImportFormat::T1dUom,
        CohortFormat::T1dsim => ImportFormat::T1dSim,
    };
    let imported = import(format, &args.source)
        .with_context(|| format!("importing '{}' as {}", args.source.display(), format.name()))?;
    let records = if args.parquet { RecordsFormat::Parquet } else { RecordsFormat::Csv };
    let config = serde_json::json!({ "from": args.from, "parquet": args.parquet });
    let manifest = Manifest::new("import", config, None).with_input(&args.source)?;

    let output = OutputFolder::begin(&args.out, manifest)?;
    write_folder(&imported.cohort, output.path(), records).context("writing the cohort")?;
    output.write_json("import_report.json", &imported.report)?;
    let place = output.finish()?;
    imported.report.lines().for_each(note);
    for inference in &imported.report.inferences {
        note(format!("inferred: {inference}"));
    }
    let findings: usize = imported.report.people.iter().map(|p| p.findings.len()).sum();
    note(format!(
        "import: {} people, {} notes and {findings} findings in {}",
        imported.cohort.people.len(),
        imported.report.notes.len(),
        place.join("import_report.json").display()
    ));
    Ok(())
}
