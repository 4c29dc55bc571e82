//! `diagnose`: where a plant misses a cohort, which effect it lacks, how far adding it goes.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use cohort::Cohort;
use gap::quality::InUse;
use gap::{Diagnoser, Diagnosis, DiagnosisConfig, GapError, InclusionRule, Plants};
use posterior::Posterior;

use crate::diagnosed::{Diagnosed, ODE};
use crate::files::{read_bytes, read_document};
use crate::people::People;
use crate::stages::report;
use crate::stated_truth::stated_truth;
use crate::tidy::write_diagnosis;
use crate::{Manifest, OutputFolder, Progress, note, table};
use ::report::count;

/// Settings of `diagnose`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Cohort folder.
    pub cohort: PathBuf,
    /// The plant to diagnose: `ode`, the file of a population model or of a person's twin, or an output
    /// folder of the command twin.
    pub model: String,
    /// The population model that twins were trained on, if it does not lie beside them.
    pub population: Option<PathBuf>,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of the bootstrap.
    pub seed: u64,
    /// A posterior, as `train-posterior` writes it, in place of that in use.
    pub posterior: Option<PathBuf>,
}

/// The manifest of a run with these arguments.
pub(crate) fn manifest(args: &Settings) -> Result<Manifest> {
    let config = serde_json::to_value(DiagnosisConfig::working())?;
    Manifest::new("diagnose", config, Some(args.seed))
        .with_input(&args.cohort)?
        .with_inputs((args.model != ODE).then_some(&args.model))?
        .with_inputs(&args.population)?
        .with_inputs(&args.posterior)
}

/// Reads a posterior.
fn posterior(file: &Path) -> Result<Posterior> {
    Posterior::from_bytes(&read_bytes(file)?).with_context(|| format!("'{}'", file.display()))
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let posterior = args.posterior.as_deref().map(posterior).transpose()?;
    let model = Diagnosed::read(&args.model, args.population.as_deref())?;
    let manifest = manifest(args)?;
    let people = People::read(&args.cohort)?;
    let judged = model.judged_on(&people.recorded)?;
    let data = if judged.cohort == people.recorded {
        people.data.clone()
    } else {
        let of_parts = InUse::of(&judged.cohort, &InclusionRule::working())?;
        of_parts.without_those_of(&people.data)
    };
    let without = model.without_residuals();
    let output = OutputFolder::begin(&args.out, manifest)?;
    people.write(&output)?;
    let runs = 1 + usize::from(without.is_some());
    let progress = Progress::begin("diagnose", runs * judged.cohort.people.len());
    let (library, config) = (effects::library(), DiagnosisConfig::working());
    let run = |cohort: &Cohort, plants: &dyn Plants| {
        let advance = |_, _| progress.advance("people");
        let mut diagnoser = Diagnoser::new(&library, &config).plants(plants).progress(&advance);
        diagnoser = diagnoser.in_use(&data);
        if let Some(posterior) = &posterior {
            diagnoser = diagnoser.posterior(posterior);
        }
        diagnoser.run(cohort, args.seed).context("the diagnosis")
    };
    let mut diagnosis = run(&judged.cohort, judged.plants.as_ref())?;
    diagnosis.notes.extend(judged.notes);
    if let Some(network) = &without {
        let same = included(&judged.cohort, &diagnosis);
        diagnosis.absorbed = match run(&same, network) {
            Ok(found) => gap::absorbed(&found, &diagnosis),
            Err(error) if matches!(error.downcast_ref(), Some(GapError::NobodyLeft { .. })) => None,
            Err(error) => return Err(error),
        };
        if diagnosis.absorbed.is_none() {
            diagnosis.notes.push(
                "Not everybody could be diagnosed without the residual, so that nothing is said of what \
                 it absorbed."
                    .to_owned(),
            );
        }
    }
    output.write_document(&diagnosis)?;
    output.write_document(&evaluation::glucose_by_person(&people.used())?)?;
    // The truth, where it is stated, is read for the report alone: the diagnosis is final.
    let written: contract::Diagnosis = read_document(output.path())?;
    write_diagnosis(output.path(), &written)?;
    let truth = stated_truth(&args.cohort, &written);
    if let Some(truth) = &truth {
        output.write_document(truth)?;
    }
    for person in &diagnosis.people {
        if let Some(reason) = &person.excluded {
            note(format!("diagnose: {} left out: {reason}", person.person_id));
        }
    }
    let excluded = diagnosis.people.iter().filter(|person| person.excluded.is_some()).count();
    report::write_into(output.path(), &output.manifest)?;
    let place = output.finish()?;
    let people = count(diagnosis.people.len(), "person", "people");
    progress
        .finish(&format!("{people}, {excluded} left out, {}", place.join("report.html").display()));
    table(::report::answer(&written, truth.as_ref()));
    Ok(())
}

/// The people who were diagnosed.
fn included(cohort: &Cohort, diagnosis: &Diagnosis) -> Cohort {
    let people = cohort.people.iter().zip(&diagnosis.people);
    let included = people.filter(|(_, summary)| summary.excluded.is_none());
    Cohort { people: included.map(|(person, _)| person.clone()).collect() }
}
