//! `diagnose`: where a plant misses a cohort, which effect it lacks, how far adding it goes.

use anyhow::{Context as _, Result, bail};
use gap::{Diagnosis, DiagnosisConfig, Verdict, diagnose_with_progress};

use crate::cli::DiagnoseArgs;
use crate::manifest::Manifest;
use crate::output::OutputFolder;
use crate::progress::Progress;
use crate::stages::report;
use crate::stages::twin::read_cohort;

/// The manifest of a run with these arguments.
pub(crate) fn manifest(args: &DiagnoseArgs) -> Result<Manifest> {
    let manifest = Manifest::new("diagnose", serde_json::to_value(config(args)?)?, Some(args.seed));
    manifest.with_input(&args.cohort)
}

/// The settings in use, with the thresholds that were asked for.
fn config(args: &DiagnoseArgs) -> Result<DiagnosisConfig> {
    let working = DiagnosisConfig::working();
    let Some(file) = &args.thresholds else { return Ok(working) };
    let text = std::fs::read(file).with_context(|| format!("reading '{}'", file.display()))?;
    let thresholds = serde_json::from_slice(&text)
        .with_context(|| format!("'{}' does not hold thresholds", file.display()))?;
    Ok(DiagnosisConfig { thresholds, ..working })
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
    let diagnosis = diagnose_with_progress(&cohort, &config(args)?, args.seed, &|_, _| {
        progress.advance("people");
    })
    .context("the diagnosis")?;
    output.write_json("diagnosis.json", &diagnosis)?;
    let excluded = diagnosis.people.iter().filter(|person| person.excluded.is_some()).count();
    report::write_into(output.path(), output.manifest())?;
    let place = output.finish()?;
    progress.finish(&format!(
        "{} people, {excluded} excluded, {}, {}",
        diagnosis.people.len(),
        verdict(&diagnosis),
        place.join("report.html").display()
    ));
    Ok(())
}

/// The answer in a few words.
fn verdict(diagnosis: &Diagnosis) -> String {
    match diagnosis.verdict {
        Verdict::None => "no effect found".to_owned(),
        Verdict::Unknown => "something unknown is missing".to_owned(),
        Verdict::Effect => {
            let names: Vec<&str> = diagnosis.effects.iter().map(|e| e.effect.as_str()).collect();
            format!("found: {}", names.join(", "))
        }
    }
}
