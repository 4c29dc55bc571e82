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
use twins::Twin;

use crate::documents::read_document;
use crate::manifest::Manifest;
use crate::models::read_population;
use crate::output::OutputFolder;
use crate::people::People as InUse;
use crate::profile::Profile;
use crate::progress::{Progress, note, table as print_table};
use crate::stages::baselines::Baselines;
use crate::stages::twin::{spread_in, twins_in, variants_in};
use crate::stages::{paper_tables, train, twin};
use crate::tidy::write_outcomes;
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
    let in_use = InUse::read(&args.cohort)?;
    let cohort = in_use.used();
    note_other_records("the twins were trained", &args.twins, &manifest);
    let people = People::read(args, &cohort)?;
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
    let mut evaluation = evaluate(&cohort, &people.models, &people.population, &settings)
        .context("the evaluation")?;
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
        let profile =
            glucose_profile(&cohort, &people.twins, &people.population, &evaluation, &protocol)
                .context("the glucose profile")?;
        output.write_document(&profile)?;
        let twins: Vec<(&str, &Twin)> =
            people.twins.iter().map(|(id, twin)| (id.as_str(), twin)).collect();
        let mut answers = what_if(&twins, &paper_plan()).context("the what-if runs")?;
        answers.order.sort_by(|a, b| a.person_id.cmp(&b.person_id));
        output.write_document(&answers)?;
        let constrained = people.constrained();
        let constrained = if constrained.is_empty() {
            None
        } else {
            let answers = what_if(&constrained, &paper_plan())
                .context("the what-if runs of twins that keep signs")?;
            output.write_document_as("what_if_constrained.json", &answers)?;
            Some(answers)
        };
        let text = paper_tables::text(
            &table,
            people.candidates.as_deref(),
            &answers,
            constrained.as_ref(),
        );
        output.write(TEXT, text.as_bytes())?;
        print_table(text);
    }
    let day = example_day(
        &cohort,
        &people.twins,
        &people.population,
        &people.models,
        &evaluation,
        &protocol,
    )
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
struct People {
    population: Arc<PopulationModel>,
    twins: BTreeMap<String, Twin>,
    models: BTreeMap<String, PersonModels>,
    /// Of whom the closest was taken, in words.
    candidates: Option<String>,
}

impl People {
    fn read(args: &Settings, cohort: &Cohort) -> Result<Self> {
        let folder = &args.twins;
        let population =
            Arc::new(read_population(&folder.join(train::MODEL)).with_context(|| {
                format!("'{}' is not an output folder of the command twin", folder.display())
            })?);
        let twins = twins_in(&folder.join(twin::TWINS), &population)?;
        let mut models = BTreeMap::new();
        for (id, twin) in &twins {
            if let Some((_, person)) = cohort.find(id) {
                models.insert(id.clone(), PersonModels::new(person, twin.clone()));
            }
        }
        let mut candidates = None;
        if let Some(folder) = &args.baselines {
            let fits = read_document::<Baselines>(folder)?;
            candidates = Some(fits.candidates);
            for fits in fits.people {
                add(&mut models, &fits.person_id, |models| {
                    let posterior = posterior_plants(&fits);
                    models
                        .with(Method::Closest, Model::Ode(plant_of(&fits.closest)))
                        .with(
                            Method::BayesianOptimisation,
                            Model::Ode(plant_of(&fits.bayesian_optimisation)),
                        )
                        .with(
                            Method::MaximumAPosteriori,
                            Model::Ode(plant_of(&fits.maximum_a_posteriori)),
                        )
                        .with(Method::Posterior, Model::Draws(posterior))
                });
            }
        }
        for (method, twins) in variants_in(folder, &population)? {
            for (id, twin) in twins {
                add(&mut models, &id, |models| models.with(method, Model::Twin(twin)));
            }
        }
        for (twin, error) in spread_in(folder, &population)? {
            let id = twin.card.person_id.clone();
            add(&mut models, &id, |models| {
                models.with(Method::SpreadTwin, Model::Spread(twin, error))
            });
        }
        Ok(Self { population, twins, models, candidates })
    }

    /// Twins that keep physiology's signs, by person.
    fn constrained(&self) -> Vec<(&str, &Twin)> {
        let people = self.models.iter();
        people
            .filter_map(|(id, models)| match models.of(Method::ConstrainedTwin) {
                Some(Model::Twin(twin)) => Some((id.as_str(), twin)),
                _ => None,
            })
            .collect()
    }
}

fn add(
    models: &mut BTreeMap<String, PersonModels>,
    id: &str,
    more: impl FnOnce(PersonModels) -> PersonModels,
) {
    if let Some(known) = models.remove(id) {
        models.insert(id.to_owned(), more(known));
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
    let days = training_days(&manifest);
    match manifest.config["profile"].as_str() {
        Some("quick") if manifest.stage == "twin" => Ok((Profile::Quick, days)),
        Some("paper") if manifest.stage == "twin" => Ok((Profile::Paper, days)),
        _ => bail!("'{}' is the output of '{}', not of twin", folder.display(), manifest.stage),
    }
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
