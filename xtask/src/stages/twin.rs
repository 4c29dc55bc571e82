//! `twin`: one residual network a person.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use cohort::{Cohort, read_folder};
use twins::evaluation::{EvaluationSettings, TwinsTable, evaluate};
use twins::{InputSet, Protocol, TrainingPlan, Twin, TwinRecipe, build_twins};

use crate::cli::{Profile, TwinArgs};
use crate::manifest::Manifest;
use crate::models::read_population;
use crate::output::OutputFolder;
use crate::progress::Progress;
use crate::stages::train;

/// Folder of the twins within the output folder.
pub(crate) const TWINS: &str = "twins";

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
    let output = OutputFolder::begin(&args.out)?;
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
    let place = output.finish(&manifest)?;
    progress.finish(&format!(
        "{trained} twins, {} people left out, {}",
        built.len() - trained,
        place.join("twins.json").display()
    ));
    Ok(())
}

/// A cohort folder.
pub(crate) fn read_cohort(folder: &Path) -> Result<Cohort> {
    read_folder(folder).with_context(|| format!("the cohort '{}'", folder.display()))
}
