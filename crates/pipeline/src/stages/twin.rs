//! `twin`: one residual network a person.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, Result, bail, ensure};
use cohort::Cohort;
use contract::run_errors::RunError;
use contract::{Document as _, RunErrors, TwinsTable};
use evaluation::{
    EvaluationSettings, HeldOutRun, Method, PersonModels, evaluate, held_out_runs,
    run_errors_by_person, twins_table,
};
use nn_statespace::PopulationModel;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use twins::{
    Doses, HeldOut, InputSet, Penalty, PersonTwin, Protocol, Signs, SteadyStates, TrainingPlan,
    Twin, TwinLoss, TwinRecipe, build_twins, build_twins_from,
};

use crate::bounds::within;
use crate::files::{find, read_document, read_population, read_twin};
use crate::people::People;
use crate::stages::train;
use crate::{Manifest, OutputFolder, Profile, Progress, note};
use ::report::count;

/// Settings of `twin`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Cohort folder.
    pub cohort: PathBuf,
    /// Population model.
    pub model: PathBuf,
    /// How much to compute.
    pub profile: Profile,
    /// Also train twins that see other personal inputs (the paper's ablation), and twins whose
    /// network keeps physiology's signs.
    pub variants: bool,
    /// Output folder of an earlier run, whose twins are trained further; `training_days` says
    /// how many days there are now.
    pub continue_from: Option<PathBuf>,
    /// Days from the start of each record that train; the profile's 14 if not given.
    pub training_days: Option<usize>,
    /// Passes over the windows; the profile's if not given. Further training needs fewer.
    pub epochs: Option<usize>,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of the initial weights and the order of the batches.
    pub seed: u64,
}

/// Folder of the twins within the output folder.
pub(crate) const TWINS: &str = "twins";
/// Folder of the twins that see other inputs or keep signs, one folder a method.
const VARIANTS: &str = "variants";

/// Most passes over the windows; their errors are kept.
const MOST_EPOCHS: usize = 100_000;
/// Most days that train: ten years.
const MOST_TRAINING_DAYS: usize = 3650;
/// Blocks of training days that are held out in turn to measure these errors.
const ERROR_BLOCKS: usize = 4;

/// How a profile cuts records and trains; `training_days` takes the place of the profile's.
pub(crate) fn protocol(profile: Profile, training_days: Option<usize>) -> (Protocol, TrainingPlan) {
    let (protocol, plan) = match profile {
        Profile::Quick => (Protocol::quick(), TrainingPlan::quick()),
        Profile::Paper => (Protocol::paper(), TrainingPlan::paper()),
    };
    let training_days = training_days.unwrap_or(protocol.training_days);
    (Protocol { training_days, ..protocol }, plan)
}

/// The twins beside the main ones: what they are called and how they are made.
fn variants(recipe: &TwinRecipe) -> Vec<(Method, TwinRecipe)> {
    let ablated =
        ablated().map(|inputs| (Method::Ablated(inputs), TwinRecipe { inputs, ..recipe.clone() }));
    // What a network that keeps signs cannot take from insulin, gains can; what it cannot follow, penalties
    // make it exaggerate.
    let plan = TrainingPlan { signs: Signs::Kept, ..without_penalties(recipe.plan) };
    let kept = TwinRecipe { plan, doses: Doses::Scaled, ..recipe.clone() };
    ablated.chain([(Method::ConstrainedTwin, kept)]).collect()
}

/// The input sets that leave something out.
fn ablated() -> impl Iterator<Item = InputSet> {
    InputSet::ALL.into_iter().filter(|inputs| *inputs != InputSet::All)
}

fn without_penalties(plan: TrainingPlan) -> TrainingPlan {
    TrainingPlan { loss: TwinLoss { penalty: Penalty::NONE, ..plan.loss }, ..plan }
}

/// Refuses days of training that no record has.
pub(crate) fn check_training_days(days: Option<usize>) -> Result<()> {
    within("--training-days", days.unwrap_or(1), 1, MOST_TRAINING_DAYS)
}

/// The manifest of a run with these arguments.
pub(crate) fn manifest(args: &Settings) -> Result<Manifest> {
    let (protocol, plan) = protocol(args.profile, args.training_days);
    let config = serde_json::json!({
        "profile": args.profile,
        "inputs": InputSet::All.name(),
        "variants": args.variants,
        "training_days": protocol.training_days,
        "epochs": args.epochs.unwrap_or(plan.epochs),
        "continued": args.continue_from.is_some(),
    });
    let manifest = Manifest::new("twin", config, Some(args.seed))
        .with_input(&args.cohort)?
        .with_model(&args.model)?;
    match &args.continue_from {
        Some(folder) if !folder.join(TWINS).is_dir() => no_twins(&folder.join(TWINS)),
        Some(folder) => manifest.with_input(&folder.join(TWINS)),
        None => Ok(manifest),
    }
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    within("--epochs", args.epochs.unwrap_or(1), 1, MOST_EPOCHS)?;
    check_training_days(args.training_days)?;
    let manifest = manifest(args)?;
    let people = People::read(&args.cohort)?;
    let cohort = people.used();
    let population = Arc::new(read_population(&args.model)?);
    let (protocol, plan) = protocol(args.profile, args.training_days);
    let recipe = TwinRecipe {
        population: Arc::clone(&population),
        protocol,
        plan: TrainingPlan { epochs: args.epochs.unwrap_or(plan.epochs), ..plan },
        inputs: InputSet::All,
        doses: Doses::Population,
        seed: args.seed,
    };
    // Earlier twins must stand on the same population model.
    let mut before = BTreeMap::new();
    if let Some(folder) = &args.continue_from {
        before = twins_in(&folder.join(TWINS), &population)?;
        if before.is_empty() {
            return no_twins(&folder.join(TWINS));
        }
    }
    let output = OutputFolder::begin(&args.out, manifest)?;
    people.write(&output)?;
    let others = if args.variants { variants(&recipe) } else { Vec::new() };
    let spread = if args.variants { ERROR_BLOCKS + 1 } else { 0 };
    let progress = Progress::begin("twin", cohort.people.len() * (1 + others.len() + spread));
    let built =
        build_twins_from(&cohort, &recipe, &before, &|person| progress.advance(&person.person_id))
            .context("training the twins")?;
    let trained = write(&output, TWINS, &built)?;
    for (method, recipe) in others {
        let built = build_twins(&cohort, &recipe, &|person| progress.advance(&person.person_id))
            .with_context(|| format!("training the twins '{}'", method.name()))?;
        write(&output, &format!("{VARIANTS}/{}", method.name()), &built)?;
    }
    if args.variants {
        let finished = |person: &PersonTwin| progress.advance(&person.person_id);
        write_spread(&output, &cohort, &recipe, &finished).context("training twins with spread")?;
    }
    let models = built
        .iter()
        .zip(&cohort.people)
        .filter_map(|(built, person)| {
            let twin = built.result.as_ref().ok()?.twin.clone();
            Some((built.person_id.clone(), PersonModels::new(person, twin)))
        })
        .collect();
    let settings = EvaluationSettings::paper(protocol, args.seed);
    let judged = evaluate(&cohort, &models, &population, &settings).context("judging the twins")?;
    let table = twins_table(&built, &judged);
    let table = TwinsTable { people: people.with_left_out(table.people), ..table };
    for row in &table.people {
        if let Some(reason) = &row.excluded {
            note(format!("twin: {} left out: {reason}", row.person_id));
        }
    }
    output.write_document(&table)?;
    // A twin is of no use without the model it was trained on.
    output.write(train::MODEL, &population.to_safetensors())?;
    let place = output.finish()?;
    progress.finish(&format!(
        "{}, {} left out, {}",
        count(trained, "twin", "twins"),
        count(people.recorded.people.len() - trained, "person", "people"),
        place.join(TwinsTable::FILE).display()
    ));
    Ok(())
}

/// Twins without penalties, and the error of their free runs on training days that were held out in turn.
fn write_spread(
    output: &OutputFolder,
    cohort: &Cohort,
    recipe: &TwinRecipe,
    finished: &(dyn Fn(&PersonTwin) + Sync),
) -> Result<()> {
    let recipe = TwinRecipe { plan: without_penalties(recipe.plan), ..recipe.clone() };
    let steady = SteadyStates::new(&*recipe.population);
    let mut runs: BTreeMap<&str, Vec<HeldOutRun>> = BTreeMap::new();
    for held_out in HeldOut::blocks(ERROR_BLOCKS) {
        let protocol = Protocol { held_out, ..recipe.protocol };
        let part = build_twins(cohort, &TwinRecipe { protocol, ..recipe.clone() }, finished)?;
        for (index, (built, person)) in part.iter().zip(&cohort.people).enumerate() {
            if let Ok(built) = &built.result {
                let found = held_out_runs(index, person, &built.twin, &steady, &protocol)?;
                runs.entry(&person.id).or_default().extend(found);
            }
        }
    }
    let built = build_twins(cohort, &recipe, finished)?;
    let trained = built.iter().filter(|person| person.result.is_ok());
    let trained = trained.map(|person| person.person_id.as_str());
    let mut rng = ChaCha8Rng::seed_from_u64(recipe.seed);
    let Some(errors) = run_errors_by_person(trained, &runs, &mut rng) else {
        note("twin: nobody has complete windows on held-out training days: no twins with spread");
        return Ok(());
    };
    let folder = format!("{VARIANTS}/{}", Method::SpreadTwin.name());
    write(output, &folder, &built)?;
    output.write_document_as(&format!("{folder}/{}", RunErrors::FILE), &errors)
}

/// The twins with spread in an output folder of this command.
pub(crate) fn spread_in(
    folder: &Path,
    population: &Arc<PopulationModel>,
) -> Result<Vec<(Twin, RunError)>> {
    let folder = folder.join(VARIANTS).join(Method::SpreadTwin.name());
    let twins = twins_in(&folder, population)?;
    if twins.is_empty() {
        return Ok(Vec::new());
    }
    let RunErrors(errors) = read_document(&folder)?;
    twins
        .into_iter()
        .map(|(id, twin)| match errors.get(&id) {
            Some(error) => Ok((twin, error.clone())),
            None => bail!(
                "'{}' lacks the error of '{id}'; train again",
                folder.join(RunErrors::FILE).display()
            ),
        })
        .collect()
}

/// Writes everybody's twin into a folder and says how many there are.
fn write(output: &OutputFolder, folder: &str, built: &[PersonTwin]) -> Result<usize> {
    let mut written = 0;
    for person in built {
        if let Ok(built) = &person.result {
            let name = format!("{folder}/{}.safetensors", person.person_id);
            output.write(&name, &built.twin.to_bytes()?)?;
            written += 1;
        }
    }
    Ok(written)
}

fn no_twins<T>(folder: &Path) -> Result<T> {
    bail!(
        "there are no twins to continue from in '{}'; give an output folder of the command twin",
        folder.display()
    )
}

/// The twins in a folder by person; none if there is no such folder.
pub(crate) fn twins_in(
    folder: &Path,
    population: &Arc<PopulationModel>,
) -> Result<BTreeMap<String, Twin>> {
    let mut twins = BTreeMap::new();
    if folder.is_dir() {
        for path in find(folder, "", ".safetensors")? {
            let twin = read_twin(&path, Arc::clone(population))?;
            twins.insert(twin.card.person_id.clone(), twin);
        }
    }
    Ok(twins)
}

/// The twins beside the main ones in an output folder of this command, by method.
pub(crate) fn variants_in(
    folder: &Path,
    population: &Arc<PopulationModel>,
) -> Result<Vec<(Method, BTreeMap<String, Twin>)>> {
    let mut found = Vec::new();
    for method in ablated().map(Method::Ablated).chain([Method::ConstrainedTwin]) {
        let folder = folder.join(VARIANTS).join(method.name());
        let twins = twins_in(&folder, population)?;
        if method == Method::ConstrainedTwin {
            for (id, twin) in &twins {
                ensure!(
                    twin.residual.keeps_signs(),
                    "the weights of '{id}' in '{}' do not keep physiology's signs; train anew",
                    folder.display()
                );
            }
        }
        if !twins.is_empty() {
            found.push((method, twins));
        }
    }
    Ok(found)
}
