//! `diagnose`: where a plant misses a cohort.

use anyhow::{Context as _, Result, bail};
use gap::{DiagnosisConfig, diagnose_with_progress};

use crate::cli::DiagnoseArgs;
use crate::manifest::Manifest;
use crate::output::OutputFolder;
use crate::progress::Progress;
use crate::stages::report;
use crate::stages::twin::read_cohort;

/// The manifest of a run with these arguments.
pub(crate) fn manifest(args: &DiagnoseArgs) -> Result<Manifest> {
    let config = serde_json::to_value(DiagnosisConfig::working())?;
    Manifest::new("diagnose", config, Some(args.seed)).with_input(&args.cohort)
}

/// Runs the command.
pub(crate) fn run(args: &DiagnoseArgs) -> Result<()> {
    if args.model != "ode" {
        bail!(
            "--model {}: this version diagnoses the ODE plant only; give --model ode or leave it out",
            args.model
        );
    }
    let manifest = manifest(args)?;
    let cohort = read_cohort(&args.cohort)?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    let progress = Progress::begin("diagnose", cohort.people.len());
    let diagnosis =
        diagnose_with_progress(&cohort, &DiagnosisConfig::working(), args.seed, &|_, _| {
            progress.advance("people");
        })
        .context("the diagnosis")?;
    output.write_json("diagnosis.json", &diagnosis)?;
    let excluded = diagnosis.people.iter().filter(|person| person.excluded.is_some()).count();
    report::write_into(output.path(), output.manifest())?;
    let place = output.finish()?;
    progress.finish(&format!(
        "{} people, {excluded} excluded, {} cells, {}",
        diagnosis.people.len(),
        diagnosis.cells.len(),
        place.join("report.html").display()
    ));
    Ok(())
}
