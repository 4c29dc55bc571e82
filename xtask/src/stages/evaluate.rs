//! `evaluate`: twins and baselines against held-out days.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use nn_statespace::PopulationModel;
use twins::Twin;
use twins::evaluation::{EvaluationSettings, OutcomesTable, evaluate};

use crate::cli::{EvaluateArgs, Profile};
use crate::manifest::Manifest;
use crate::models::{find, read_population, read_twin};
use crate::output::OutputFolder;
use crate::progress::{Progress, note};
use crate::stages::twin::read_cohort;
use crate::stages::{example_day, glucose_profile, train, twin};

/// Fewest people over whom an equivalence test is defined.
const FEWEST_PEOPLE: usize = 2;

/// The manifest of a run with these arguments.
pub(crate) fn manifest(args: &EvaluateArgs) -> Result<Manifest> {
    let config = serde_json::json!({ "profile": profile_of(&args.twins)? });
    Manifest::new("evaluate", config, Some(args.seed))
        .with_input(&args.cohort)?
        .with_input(&args.twins)
}

/// Runs the command.
pub(crate) fn run(args: &EvaluateArgs) -> Result<()> {
    let manifest = manifest(args)?;
    let cohort = read_cohort(&args.cohort)?;
    note_other_records(&args.twins, &manifest);
    let (population, twins) = read_twins(&args.twins)?;
    let (protocol, _) = twin::protocol(profile_of(&args.twins)?);
    let settings = EvaluationSettings::paper(protocol, args.seed);

    let output = OutputFolder::begin(&args.out, manifest)?;
    let progress = Progress::begin("evaluate", 1);
    let evaluation = evaluate(&cohort, &twins, &population, &settings).context("the evaluation")?;
    let name = cohort_name(&args.cohort);
    let judged = evaluation.people.len();
    for excluded in &evaluation.exclusions {
        note(format!("evaluate: {} left out: {}", excluded.person_id, excluded.reason));
    }
    if judged < FEWEST_PEOPLE {
        note(format!(
            "evaluate: {judged} judged; tests over people need {FEWEST_PEOPLE}, so that there are no \
             outcomes"
        ));
        output.write_json("exclusions.json", &evaluation.exclusions)?;
    } else {
        let table = OutcomesTable::new(&name, &evaluation, &settings)?;
        output.write_json("outcomes.json", &table)?;
        let profile = glucose_profile::over_held_out_windows(
            &cohort,
            &twins,
            &population,
            &evaluation,
            &protocol,
        )?;
        output.write_json("agp.json", &profile)?;
        let text = text(&table);
        output.write("outcomes.txt", text.as_bytes())?;
        note(text);
    }
    if let Some(day) = example_day::choose(&cohort, &twins, &evaluation, &protocol) {
        let day = example_day::simulate_day(&cohort, &twins, &population, &day, &protocol)?;
        output.write_json("example_day.json", &day)?;
    }
    progress.advance("people");
    let place = output.finish()?;
    progress.finish(&format!(
        "{judged} people judged, {} left out, {}",
        evaluation.exclusions.len(),
        place.display()
    ));
    Ok(())
}

/// Says so if the twins were trained on other records: held-out days may not be held out then.
fn note_other_records(twins: &Path, manifest: &Manifest) {
    let Some(trained) = Manifest::read(twins) else { return };
    let records = |path: &str| path.ends_with("records.csv") || path.ends_with("records.parquet");
    let known = |hash: &str| trained.inputs.iter().any(|input| input.sha256 == hash);
    if manifest.inputs.iter().any(|input| records(&input.path) && !known(&input.sha256)) {
        note(
            "evaluate: the twins were trained on other records than these; days that are held out \
             here may have trained them",
        );
    }
}

/// The folder's name, or its parent's where the folder is just called "cohort".
fn cohort_name(folder: &Path) -> String {
    let named = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
    match named(folder) {
        Some(name) if name == "cohort" => folder.parent().and_then(named).unwrap_or(name),
        Some(name) => name,
        None => folder.display().to_string(),
    }
}

/// The population model and the twins in an output folder of `twin`.
fn read_twins(folder: &Path) -> Result<(Arc<PopulationModel>, BTreeMap<String, Twin>)> {
    let population = Arc::new(read_population(&folder.join(train::MODEL)).with_context(|| {
        format!("'{}' is not an output folder of the command twin", folder.display())
    })?);
    let twins_folder: PathBuf = folder.join(twin::TWINS);
    let mut twins = BTreeMap::new();
    if twins_folder.is_dir() {
        for path in find(&twins_folder, "", ".safetensors")? {
            let twin = read_twin(&path, Arc::clone(&population))?;
            twins.insert(twin.card.person_id.clone(), twin);
        }
    }
    Ok((population, twins))
}

/// The profile with which the twins were trained, so that held-out days stay held out.
fn profile_of(folder: &Path) -> Result<Profile> {
    let Some(manifest) = Manifest::read(folder) else {
        bail!("'{}' has no manifest; give an output folder of the command twin", folder.display());
    };
    match manifest.config["profile"].as_str() {
        Some("quick") if manifest.stage == "twin" => Ok(Profile::Quick),
        Some("paper") if manifest.stage == "twin" => Ok(Profile::Paper),
        _ => bail!("'{}' is the output of '{}', not of twin", folder.display(), manifest.stage),
    }
}

/// The outcomes as text.
fn text(table: &OutcomesTable) -> String {
    use std::fmt::Write as _;
    let mut text = format!(
        "{} people, {} windows of {} min\n{:<12} {:<5} {:>15} {:>15} {:>24} {:>7} {}\n",
        table.people,
        table.windows,
        table.window_minutes,
        "method",
        "",
        "actual",
        "simulated",
        "difference (interval)",
        "p",
        "equivalent"
    );
    for method in &table.methods {
        for row in &method.rows {
            writeln!(
                text,
                "{:<12} {:<5} {:>7.1} ± {:>5.1} {:>7.1} ± {:>5.1} {:>8.2} ({:>6.2}, {:>6.2}) {:>7.3} {}",
                method.name,
                row.metric,
                row.actual.mean,
                row.actual.sd,
                row.simulated.mean,
                row.simulated.sd,
                row.difference.value,
                row.difference.lower,
                row.difference.upper,
                row.p,
                if row.equivalent { "yes" } else { "no" }
            )
            .expect("writing to a String cannot fail");
        }
        writeln!(
            text,
            "{:<12} 5-hour RMSE {:.1} ± {:.1} mg/dL",
            method.name, method.rmse_5h.mean, method.rmse_5h.sd
        )
        .expect("writing to a String cannot fail");
    }
    text
}
