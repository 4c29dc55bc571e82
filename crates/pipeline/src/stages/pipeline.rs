//! `pipeline`: every stage from a cohort to the report, each complete or absent, resumed by manifest.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};
use cohort::{Cohort, ImportReport, PersonImport, findings, mass_balance};
use contract::{Document as _, RegionFile};

use crate::diagnosed::ODE;
use crate::files::{read_document, read_population};
use crate::lock::Lock;
use crate::manifest::REPORT;
use crate::next_step::wrote;
use crate::output::{self, followed, write_whole};
use crate::people::{People, read_cohort};
use crate::progress::{json_is_asked_for, print_no_results};
use crate::result_file::print_result;
use crate::stages::simulate::read_patients;
use crate::stages::{
    baselines, diagnose, evaluate, held_out, paper_tables, report, train, twin, verify,
};
use crate::{Manifest, OutputFolder, Profile, ask_for_json, note, workspace_root};
use ::report::count;

named::named! {
    /// The stages, in order.
    Stage {
        /// Read and judge the cohort's records.
        Cohort: "cohort",
        /// Simulate days and train the population network.
        Train: "train",
        /// Prove or refute the network's monotonicity.
        Verify: "verify",
        /// Compare the network with the ODE on simulated days that trained neither.
        HeldOut: "held-out",
        /// Train a twin a person, and its variants.
        Twin: "twin",
        /// Fit what twins are compared with.
        Baselines: "baselines",
        /// Compare with held-out days.
        Evaluate: "evaluate",
        /// Say where the ODE plant misses.
        Diagnose: "diagnose",
        /// Write the report.
        Report: "report",
    }
}

impl Stage {
    /// Its folder in the output of a pipeline: its place and its name, the report's without a place.
    #[must_use]
    pub fn folder(self) -> String {
        let name = self.name();
        if self == Self::Report { name.into() } else { format!("{}-{name}", self as usize + 1) }
    }
}

/// Settings of `pipeline`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// How much to compute.
    pub profile: Profile,
    /// Cohort folder; the embedded cohort if not given.
    pub cohort: Option<PathBuf>,
    /// Population model to use instead of training one.
    pub model: Option<PathBuf>,
    /// Virtual patients of whom the closest is taken, in the columns of the published population; 99
    /// of our own where it is not given.
    pub patients: Option<PathBuf>,
    /// Compute this stage and all after it anew.
    pub from: Option<Stage>,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of everything random.
    pub seed: u64,
}

/// Time limit of a conformance row in the quick profile, s.
const QUICK_ROW_SECONDS: f64 = 5.0;
/// Time limit of a conformance row in the paper profile, s.
const PAPER_ROW_SECONDS: f64 = 60.0;

/// Every table of the paper, as text.
const TABLES: &str = "tables.txt";

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    if let Some(model) = args.model.as_deref().filter(|model| !model.is_file()) {
        bail!("there is no model file '{}'", model.display());
    }
    if let Some(patients) = args.patients.as_deref().filter(|patients| !patients.is_file()) {
        bail!("there is no file of virtual patients '{}'", patients.display());
    }
    if let Some(cohort) = args.cohort.as_deref().filter(|cohort| !cohort.is_dir()) {
        bail!("there is no cohort folder '{}'", cohort.display());
    }
    let cohort = match &args.cohort {
        Some(folder) => folder.clone(),
        None => embedded_cohort()?,
    };
    // Every input is opened before any work: a fault in the last of them must not show after hours.
    People::read_quietly(&cohort)?;
    args.model.as_deref().map(read_population).transpose()?;
    args.patients.as_deref().map(read_patients).transpose()?;
    let json = json_is_asked_for();
    if json {
        // The results of its stages are in their folders.
        print_no_results();
    }
    let out = followed(&args.out)?;
    ensure!(out.is_dir() || !out.exists(), "'{}' is a file; give --out a folder", out.display());
    let recorded = Manifest::new("cohort", serde_json::json!({}), None).with_input(&cohort)?;
    if let Some(input) = recorded.folder_around(&out.join(TABLES)) {
        bail!(
            "'{}' lies in '{}', an input of this run; give another --out",
            out.display(),
            input.display()
        );
    }
    std::fs::create_dir_all(&out)
        .with_context(|| format!("cannot make the folder '{}'", out.display()))?;
    let _lock = Lock::hold(&out)?;
    let args = &Settings { out, ..args.clone() };
    let at = |stage: Stage| args.out.join(stage.folder());

    let folder = at(Stage::Cohort);
    let judge = || judge_cohort(&cohort, &folder, recorded.clone());
    step(args, Stage::Cohort, recorded.clone(), judge)?;

    let model = match &args.model {
        Some(path) => {
            discard(args, Stage::Train)?;
            path.clone()
        }
        None => {
            let train = train::Settings {
                profile: args.profile,
                preset: train::TrainingPreset::Working,
                patience: None,
                out: at(Stage::Train),
                seed: args.seed,
            };
            step(args, Stage::Train, train::manifest(&train), || train::run(&train))?;
            train.out.join(train::MODEL)
        }
    };

    // A model of unknown training range cannot be verified without a box; the report says so.
    if args.model.is_none() || model.with_file_name(RegionFile::FILE).is_file() {
        let limit = match args.profile {
            Profile::Quick => QUICK_ROW_SECONDS,
            Profile::Paper => PAPER_ROW_SECONDS,
        };
        let verify = verify::Settings {
            model: model.clone(),
            region: None,
            limit,
            repair: false,
            widen: 0.0,
            delta: None,
            milp: verify::MilpForm::Gradient,
            out: at(Stage::Verify),
            seed: args.seed,
        };
        step(args, Stage::Verify, verify::manifest(&verify)?, || verify::run(&verify))?;
    } else {
        discard(args, Stage::Verify)?;
        note(format!(
            "verify: left out, since there is no {} beside '{}'",
            RegionFile::FILE,
            model.display()
        ));
    }

    let held_out = held_out::Settings {
        model: model.clone(),
        beside: None,
        profile: args.profile,
        seed: args.seed,
        out: at(Stage::HeldOut),
    };
    step(args, Stage::HeldOut, held_out::manifest(&held_out)?, || held_out::run(&held_out))?;

    let twin = twin::Settings {
        cohort: cohort.clone(),
        model,
        profile: args.profile,
        variants: true,
        continue_from: None,
        training_days: None,
        epochs: None,
        out: at(Stage::Twin),
        seed: args.seed,
    };
    step(args, Stage::Twin, twin::manifest(&twin)?, || twin::run(&twin))?;

    let baselines = baselines::Settings {
        cohort: cohort.clone(),
        model: twin.model.clone(),
        patients: args.patients.clone(),
        profile: args.profile,
        training_days: None,
        out: at(Stage::Baselines),
        seed: args.seed,
    };
    step(args, Stage::Baselines, baselines::manifest(&baselines)?, || baselines::run(&baselines))?;

    let evaluate = evaluate::Settings {
        cohort: cohort.clone(),
        twins: twin.out.clone(),
        baselines: Some(baselines.out.clone()),
        out: at(Stage::Evaluate),
        seed: args.seed,
    };
    step(args, Stage::Evaluate, evaluate::manifest(&evaluate)?, || evaluate::run(&evaluate))?;

    let diagnose = diagnose::Settings {
        cohort,
        model: ODE.to_owned(),
        population: None,
        out: at(Stage::Diagnose),
        seed: args.seed,
        posterior: None,
    };
    step(args, Stage::Diagnose, diagnose::manifest(&diagnose)?, || diagnose::run(&diagnose))?;

    report::run(&report::Settings { folder: args.out.clone() })?;
    let model = read_population(&twin.model)?;
    let parts = [
        at(Stage::HeldOut).join(held_out::TEXT),
        at(Stage::Verify).join(verify::TEXT),
        at(Stage::Evaluate).join(evaluate::TEXT),
    ];
    let text = paper_tables::all(&model, &parts)?;
    let path = args.out.join(TABLES);
    write_whole(&path, text.as_bytes())?;
    note(format!("pipeline: every table of the paper: {}", path.display()));
    wrote("pipeline", &args.out, None);
    if json {
        ask_for_json();
        print_result("pipeline", &at(Stage::Diagnose));
    }
    Ok(())
}

/// Runs a stage unless its folder already holds the same work.
fn step(
    args: &Settings,
    stage: Stage,
    manifest: Manifest,
    work: impl FnOnce() -> Result<()>,
) -> Result<()> {
    let folder = args.out.join(stage.folder());
    let wanted_anew = args.from.is_some_and(|from| stage >= from);
    let done = Manifest::read(&folder)
        .is_some_and(|before| before.same_work(&manifest) && before.outputs_intact_in(&folder));
    if done && !wanted_anew {
        note(format!("{}: done before, kept ({})", stage.name(), folder.display()));
        return Ok(());
    }
    // What follows from an older result must not stand beside the new one, even if a later stage
    // fails.
    for later in Stage::ALL.into_iter().filter(|later| *later > stage) {
        discard(args, later)?;
    }
    work().with_context(|| format!("stage {}", stage.name()))
}

/// Removes an earlier result of a stage, and the report and tables that may show it.
fn discard(args: &Settings, stage: Stage) -> Result<()> {
    for file in [REPORT, TABLES] {
        let file = args.out.join(file);
        if file.is_file() {
            std::fs::remove_file(&file)
                .with_context(|| format!("cannot remove the outdated '{}'", file.display()))?;
        }
    }
    let folder = args.out.join(stage.folder());
    let Some(before) = Manifest::read(&folder) else { return Ok(()) };
    if let Some(stranger) = before.strangers_in(&folder)?.first() {
        bail!(
            "'{}' is outdated but holds a file that this program did not write ({stranger}); move \
             it elsewhere",
            folder.display()
        );
    }
    output::discard(&folder)
}

/// The cohort that lies in the repository.
///
/// # Errors
/// Where this program was built from a repository that is no longer there.
fn embedded_cohort() -> Result<PathBuf> {
    let folder = workspace_root().join("fixtures/embedded/cohort");
    ensure!(
        folder.is_dir(),
        "the embedded cohort is not at '{}', where this program was built; give --cohort DIR",
        folder.display()
    );
    Ok(folder)
}

/// Reads the records and says, person by person, whether their amounts are plausible.
fn judge_cohort(folder: &Path, out: &Path, manifest: Manifest) -> Result<()> {
    let cohort = read_cohort(folder)?;
    let output = OutputFolder::begin(out, manifest)?;
    output.write_document(&account(&cohort, folder)?)?;
    for person in &cohort.people {
        note(mass_balance(person).to_string());
    }
    output.finish()?;
    note(format!("cohort: {}", count(cohort.people.len(), "person", "people")));
    Ok(())
}

/// The importer's own account, if it lies in the cohort folder; else one made from the records.
fn account(cohort: &Cohort, folder: &Path) -> Result<ImportReport> {
    if folder.join(ImportReport::FILE).is_file() {
        return read_document(folder);
    }
    let people = cohort.people.iter().map(|person| {
        let balance = mass_balance(person);
        PersonImport {
            line: balance.to_string(),
            balance,
            therapy: None,
            totals: None,
            findings: findings(person),
        }
    });
    Ok(ImportReport {
        format: "cohort folder".to_owned(),
        days_are: None,
        people: people.collect(),
        inferences: None,
        notes: Vec::new(),
    })
}
