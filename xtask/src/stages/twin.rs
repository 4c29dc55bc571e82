//! `twin`: one residual network a person.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use cohort::{Cohort, findings, read_folder};
use twins::evaluation::{EvaluationSettings, TwinsTable, evaluate};
use twins::{InputSet, Protocol, TrainingPlan, Twin, TwinRecipe, build_twins};

use crate::cli::{Profile, TwinArgs};
use crate::manifest::Manifest;
use crate::models::read_population;
use crate::output::OutputFolder;
use crate::progress::{Progress, note};
use crate::stages::train;

/// Folder of the twins within the output folder.
pub(crate) const TWINS: &str = "twins";

/// Implausible figures of a cohort that are said.
const FINDINGS_SAID: usize = 10;

/// How a profile cuts records and trains.
pub(crate) fn protocol(profile: Profile) -> (Protocol, TrainingPlan) {
    match profile {
        Profile::Quick => (Protocol::quick(), TrainingPlan::quick()),
        Profile::Paper => (Protocol::paper(), TrainingPlan::paper()),
    }
}

/// The manifest of a run with these arguments.
pub(crate) fn manifest(args: &TwinArgs) -> Result<Manifest> {
    let config = serde_json::json!({ "profile": args.profile, "inputs": InputSet::All.name() });
    Manifest::new("twin", config, Some(args.seed)).with_input(&args.cohort)?.with_input(&args.model)
}

/// Runs the command.
pub(crate) fn run(args: &TwinArgs) -> Result<()> {
    let manifest = manifest(args)?;
    let cohort = read_cohort(&args.cohort)?;
    let population = Arc::new(read_population(&args.model)?);
    let (protocol, plan) = protocol(args.profile);
    let recipe = TwinRecipe {
        population: Arc::clone(&population),
        protocol,
        plan,
        inputs: InputSet::All,
        seed: args.seed,
    };
    let output = OutputFolder::begin(&args.out, manifest)?;
    let progress = Progress::begin("twin", cohort.people.len());
    let built = build_twins(&cohort, &recipe, &|person| progress.advance(&person.person_id))
        .context("training the twins")?;
    let mut trained = 0;
    for person in &built {
        if let Ok(built) = &person.result {
            trained += 1;
            let name = format!("{TWINS}/{}.safetensors", person.person_id);
            output.write(&name, &built.twin.to_bytes()?)?;
        }
    }
    let twins: BTreeMap<String, Twin> = built
        .iter()
        .filter_map(|person| {
            Some((person.person_id.clone(), person.result.as_ref().ok()?.twin.clone()))
        })
        .collect();
    let settings = EvaluationSettings::paper(protocol, args.seed);
    let judged = evaluate(&cohort, &twins, &population, &settings).context("judging the twins")?;
    output.write_json("twins.json", &TwinsTable::new(&built, &judged))?;
    // A twin is of no use without the model it was trained on.
    output.write(train::MODEL, &population.to_safetensors())?;
    let place = output.finish()?;
    progress.finish(&format!(
        "{trained} twins, {} people left out, {}",
        built.len() - trained,
        place.join("twins.json").display()
    ));
    Ok(())
}

/// A cohort folder.
///
/// What is implausible in it is said, a line each, up to a limit; nothing is changed.
pub(crate) fn read_cohort(folder: &Path) -> Result<Cohort> {
    let cohort =
        read_folder(folder).with_context(|| format!("the cohort '{}'", folder.display()))?;
    let found: Vec<_> = cohort.people.iter().flat_map(findings).collect();
    for finding in found.iter().take(FINDINGS_SAID) {
        note(format!("implausible: {finding}"));
    }
    if found.len() > FINDINGS_SAID {
        note(format!("implausible: {} findings more", found.len() - FINDINGS_SAID));
    }
    Ok(cohort)
}
