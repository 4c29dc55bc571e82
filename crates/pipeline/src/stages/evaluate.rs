//! `evaluate`: twins and baselines against held-out days.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, Result, bail, ensure};
use cohort::Cohort;
use contract::{Document as _, Exclusions, OutcomesTable, TwinsTable};
use evaluation::{
    EvaluationSettings, Method, Model, PersonModels, evaluate, example_day, glucose_profile,
    outcomes_table, paper_plan, what_if,
};
use nn_statespace::PopulationModel;
use ode_twins::{plant_of, posterior_plants};
use serde::Deserialize as _;
use twins::Twin;

use crate::files::{read_document, read_population};
use crate::people::People;
use crate::stages::baselines::Baselines;
use crate::stages::twin::{spread_in, twins_in, variants_in};
use crate::stages::{paper_tables, train, twin};
use crate::tidy::write_outcomes;
use crate::{Manifest, OutputFolder, Profile, Progress, note, table as print_table};
use ::report::count;

/// Settings of `evaluate`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Cohort folder.
    pub cohort: PathBuf,
    /// Output folder of `twin`.
    pub twins: PathBuf,
    /// Output folder of `baselines`.
    pub baselines: Option<PathBuf>,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of the bootstrap.
    pub seed: u64,
}

/// Fewest people over whom an equivalence test is defined.
const FEWEST_PEOPLE: usize = 2;

/// The tables as text, within the output folder.
pub(crate) const TEXT: &str = "tables.txt";

/// The manifest of a run with these arguments.
pub(crate) fn manifest(args: &Settings) -> Result<Manifest> {
    let (profile, training_days) = trained_with(&args.twins)?;
    let config = serde_json::json!({ "profile": profile, "training_days": training_days });
    Manifest::new("evaluate", config, Some(args.seed))
        .with_input(&args.cohort)?
        .with_input(&args.twins)?
        .with_inputs(&args.baselines)
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let manifest = manifest(args)?;
    let in_use = People::read(&args.cohort)?;
    let cohort = in_use.used();
    note_other_records("the twins were trained", &args.twins, &manifest);
    let Models { population, twins, models, candidates } = Models::read(args, &cohort)?;
    let (profile, training_days) = trained_with(&args.twins)?;
    if let Some(baselines) = &args.baselines {
        note_other_records("the baselines were fitted", baselines, &manifest);
        check_fitted_with(baselines, training_days)?;
    }
    let (protocol, _) = twin::protocol(profile, training_days);
    let settings = EvaluationSettings::paper(protocol, args.seed);

    let output = OutputFolder::begin(&args.out, manifest)?;
    in_use.write(&output)?;
    let progress = Progress::begin("evaluate", 1);
    let mut evaluation =
        evaluate(&cohort, &models, &population, &settings).context("the evaluation")?;
    evaluation.exclusions.extend(in_use.left_out());
    let judged = evaluation.people.len();
    for excluded in &evaluation.exclusions {
        note(format!("evaluate: {} left out: {}", excluded.person_id, excluded.reason));
    }
    if judged < FEWEST_PEOPLE {
        note(format!(
            "evaluate: {judged} judged; outcomes are tests over people and need {FEWEST_PEOPLE}, so that there \
             is no {}; the errors on held-out days of each person are in {} of twin",
            OutcomesTable::FILE,
            TwinsTable::FILE
        ));
        output.write_document(&Exclusions(evaluation.exclusions.clone()))?;
    } else {
        let table = outcomes_table(&cohort_name(&args.cohort), &evaluation, &settings)?;
        output.write_document(&table)?;
        write_outcomes(output.path(), &evaluation)?;
        let profile = glucose_profile(&cohort, &twins, &population, &evaluation, &protocol)
            .context("the glucose profile")?;
        output.write_document(&profile)?;
        let own: Vec<(&str, &Twin)> = twins.iter().map(|(id, twin)| (id.as_str(), twin)).collect();
        let mut answers = what_if(&own, &paper_plan()).context("the what-if runs")?;
        answers.order.sort_by(|a, b| a.person_id.cmp(&b.person_id));
        output.write_document(&answers)?;
        let constrained =
            models.iter().filter_map(|(id, models)| match models.of(Method::ConstrainedTwin) {
                Some(Model::Twin(twin)) => Some((id.as_str(), twin)),
                _ => None,
            });
        let constrained: Vec<(&str, &Twin)> = constrained.collect();
        let constrained = if constrained.is_empty() {
            None
        } else {
            let answers = what_if(&constrained, &paper_plan())
                .context("the what-if runs of twins that keep signs")?;
            output.write_document_as("what_if_constrained.json", &answers)?;
            Some(answers)
        };
        let text =
            paper_tables::text(&table, candidates.as_deref(), &answers, constrained.as_ref());
        output.write(TEXT, text.as_bytes())?;
        print_table(text);
    }
    let day = example_day(&cohort, &twins, &population, &models, &evaluation, &protocol)
        .context("the example days")?;
    if let Some(day) = day {
        output.write_document(&day)?;
    }
    progress.advance("people");
    let place = output.finish()?;
    progress.finish(&format!(
        "{} judged, {} left out, {}",
        count(judged, "person", "people"),
        evaluation.exclusions.len(),
        place.display()
    ));
    Ok(())
}

/// Everything that stands for the people of a cohort.
struct Models {
    population: Arc<PopulationModel>,
    twins: BTreeMap<String, Twin>,
    models: BTreeMap<String, PersonModels>,
    /// Of whom the closest was taken, in words.
    candidates: Option<String>,
}

impl Models {
    fn read(args: &Settings, cohort: &Cohort) -> Result<Self> {
        let folder = &args.twins;
        let population = read_population(&folder.join(train::MODEL)).with_context(|| {
            format!("'{}' is not an output folder of the command twin", folder.display())
        })?;
        let population = Arc::new(population);
        let twins = twins_in(&folder.join(twin::TWINS), &population)?;
        let mut models = BTreeMap::new();
        for (id, twin) in &twins {
            if let Some((_, person)) = cohort.find(id) {
                models.insert(id.clone(), PersonModels::new(person, twin.clone()));
            }
        }
        let mut candidates = None;
        let mut others: Vec<(String, Method, Model)> = Vec::new();
        if let Some(folder) = &args.baselines {
            let fits = read_document::<Baselines>(folder)?;
            candidates = Some(fits.candidates);
            for fits in fits.people {
                let mut add = |method, model| others.push((fits.person_id.clone(), method, model));
                let plant = |fitted| Model::Ode(plant_of(fitted));
                add(Method::Closest, plant(&fits.closest));
                add(Method::BayesianOptimisation, plant(&fits.bayesian_optimisation));
                add(Method::MaximumAPosteriori, plant(&fits.maximum_a_posteriori));
                add(Method::Posterior, Model::Draws(posterior_plants(&fits)));
            }
        }
        for (method, twins) in variants_in(folder, &population)? {
            others.extend(twins.into_iter().map(|(id, twin)| (id, method, Model::Twin(twin))));
        }
        for (twin, error) in spread_in(folder, &population)? {
            let id = twin.card.person_id.clone();
            others.push((id, Method::SpreadTwin, Model::Spread(twin, error)));
        }
        for (id, method, model) in others {
            if let Some(known) = models.remove(&id) {
                models.insert(id, known.with(method, model));
            }
        }
        Ok(Self { population, twins, models, candidates })
    }
}

/// Says so if models stand on other records: held-out days may not be held out then.
fn note_other_records(done: &str, folder: &Path, manifest: &Manifest) {
    let Some(trained) = Manifest::read(folder) else { return };
    let records = |path: &str| path.ends_with("records.csv") || path.ends_with("records.parquet");
    let known = |hash: &str| trained.inputs.iter().any(|input| input.sha256 == hash);
    if manifest.inputs.iter().any(|input| records(&input.path) && !known(&input.sha256)) {
        note(format!(
            "evaluate: {done} on other records than these; days that are held out here may be among \
             them"
        ));
    }
}

/// The folder's name, or its parent's where the folder is just called "cohort".
pub(crate) fn cohort_name(folder: &Path) -> String {
    let named = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
    match named(folder) {
        Some(name) if name == "cohort" => folder.parent().and_then(named).unwrap_or(name),
        Some(name) => name,
        None => folder.display().to_string(),
    }
}

/// The profile and the days with which the twins were trained, so that held-out days stay held out.
fn trained_with(folder: &Path) -> Result<(Profile, Option<usize>)> {
    let Some(manifest) = Manifest::read(folder) else {
        bail!("'{}' has no manifest; give an output folder of the command twin", folder.display());
    };
    let profile = Profile::deserialize(&manifest.config["profile"]).ok();
    let profile = profile.filter(|_| manifest.stage == "twin").with_context(|| {
        format!("'{}' is the output of '{}', not of twin", folder.display(), manifest.stage)
    })?;
    Ok((profile, training_days(&manifest)))
}

fn training_days(manifest: &Manifest) -> Option<usize> {
    manifest.config["training_days"].as_u64().and_then(|n| usize::try_from(n).ok())
}

/// Refuses baselines that were fitted to other days than those that trained the twins: they may have seen days that
/// test.
fn check_fitted_with(folder: &Path, trained: Option<usize>) -> Result<()> {
    let fitted = Manifest::read(folder).and_then(|manifest| training_days(&manifest));
    let days = |days: Option<usize>| days.map_or("unknown".to_owned(), |days| days.to_string());
    ensure!(
        fitted == trained,
        "'{}': training days {}, and {} of the twins; give the commands twin and baselines the same --training-days",
        folder.display(),
        days(fitted),
        days(trained)
    );
    Ok(())
}
