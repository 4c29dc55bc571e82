//! What was typed: the commands and their options.
//!
//! This file only describes the words; what they mean to a stage says `settings`.

mod words;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use pipeline::Profile;
use pipeline::stages::export::ExportFormat;
use pipeline::stages::import::{DateOrder, ImportFormat};
use pipeline::stages::import_model::ModelFormat;
use pipeline::stages::pipeline::Stage;
use pipeline::stages::reconcile::{DetectorName, Rule};
use pipeline::stages::replay::Initial;
use pipeline::stages::train::TrainingPreset;
use pipeline::stages::verify::MilpForm;
use pipeline::stages::worlds::{Generator, RegimeName};

use words::{
    DATE_ORDER, DETECTOR, EXPORT_FORMAT, MILP_FORM, MODEL_FORMAT, PROFILE, REGIME, RULE, STAGE,
    TRAINING_PRESET, one_of,
};

/// Digital twins for type 1 diabetes: simulate, train, prove, personalise, judge, diagnose.
///
/// Research software. Not a medical device; not validated for any treatment decision.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version, max_term_width = 100)]
#[command(after_help = "Exit status: 0 done, 1 bad input (said in one message), 2 wrong usage.")]
pub(crate) struct CommandLine {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// No progress, no notes: the result's tables and errors only.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Print the result as JSON in place of its tables.
    #[arg(long, global = true)]
    pub json: bool,
    /// Number of threads [default: all cores]. Results do not depend on it.
    #[arg(long, global = true, value_name = "N")]
    pub threads: Option<usize>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Every stage from a cohort to the report.
    #[command(after_help = examples("pipeline
        pipeline --cohort out/hupa --out out/hupa-pipeline
        pipeline --from twin"))]
    Pipeline(PipelineArgs),
    /// Turn a study's files, or anybody's tables, into a cohort folder.
    #[command(after_help = examples("import --from hupa-ucm path/to/HUPA --out out/hupa
        import --from dexcom Clarity_Export.csv --out out/mine
        import --from table my.csv --guess
        import --from table my.csv --map \"time=Date,glucose=Value\" --unit glucose=mmol/L --zone \
        Europe/Madrid"))]
    Import(ImportArgs),
    /// Write a cohort in a format that other programs read.
    #[command(after_help = examples("export --cohort fixtures/embedded/cohort --to iglu --out \
        out/iglu"))]
    Export(ExportArgs),
    /// Check a cohort folder, or write a template of one.
    #[command(subcommand, after_help = examples("cohort new mine
        cohort check mine"))]
    Cohort(CohortCommand),
    /// Simulate virtual patients of the ODE model through the test scenario of the published population.
    #[command(after_help = examples("simulate --patients patients.csv --meals meals.csv --initial \
        initial_states.csv --out out/traces"))]
    Simulate(SimulateArgs),
    /// Simulate the days on which the population network is trained, and write them as Parquet.
    #[command(after_help = examples("development-set --out out/development-set
        development-set --profile paper --out out/development-set"))]
    DevelopmentSet(DevelopmentSetArgs),
    /// Train the population network on simulated days.
    #[command(after_help = examples("train --profile quick --seed 1 --out out/train")
        + "\n\nA run that was ended goes on where it stopped when the same command is given again.")]
    Train(TrainArgs),
    /// Convert published PyTorch weights into a model file.
    #[command(after_help = examples("import-model --from t1dsim path/to/T1DSim_AI --out \
        out/published"))]
    ImportModel(ImportModelArgs),
    /// Prove or refute the physiological monotonicity of a population network.
    #[command(after_help = examples("verify --model out/train/population.safetensors --region \
        region.json --out out/verify"))]
    Verify(VerifyArgs),
    /// Train one digital twin a person.
    #[command(after_help = examples("twin --cohort fixtures/embedded/cohort --model \
        out/train/population.safetensors --out out/twin"))]
    Twin(TwinArgs),
    /// Fit what twins are compared with: closest virtual patient, Bayesian optimisation, most probable
    /// parameters, posterior.
    #[command(after_help = examples("baselines --cohort fixtures/embedded/cohort --model \
        out/train/population.safetensors --out out/baselines"))]
    Baselines(BaselinesArgs),
    /// Simulate a cohort's record with a model, from its first glucose reading.
    #[command(after_help = examples("replay --cohort out/day --model population.safetensors
        replay --cohort out/day --model population.safetensors --twin twin.safetensors --initial \
        table:initSteadyStates.csv"))]
    Replay(ReplayArgs),
    /// Reconcile a cohort's logged carbohydrate with the meals that sensor and insulin show.
    #[command(after_help = examples("reconcile --cohort fixtures/embedded/cohort --out \
        out/reconcile"))]
    Reconcile(ReconcileArgs),
    /// Compare simulated with recorded glucose on held-out days.
    #[command(after_help = examples("evaluate --cohort fixtures/embedded/cohort --twins out/twin \
        --baselines out/baselines --out out/evaluate"))]
    Evaluate(EvaluateArgs),
    /// Say where a model misses a cohort.
    #[command(after_help = examples("diagnose --cohort fixtures/embedded/cohort --out out/diagnose
        diagnose --cohort fixtures/embedded/cohort --model out/train/population.safetensors
        diagnose --cohort fixtures/embedded/cohort --model out/twin"))]
    Diagnose(DiagnoseArgs),
    /// Compare twins whose plant has the named effects with twins that must absorb them.
    #[command(after_help = examples("effect-twins --cohort fixtures/embedded/cohort --model \
        crates/nn-statespace/model/population.safetensors"))]
    EffectTwins(EffectTwinsArgs),
    /// Ask the diagnosis for effects that are hidden from it, and score the answers.
    #[command(after_help = examples("blind-check
        blind-check --full --out out/blind-check
        blind-check --worlds 7 --nulls 3 --seed 5"))]
    BlindCheck(BlindCheckArgs),
    /// Make cohorts with known effects, with their labels beside them.
    #[command(after_help = examples("worlds --effect dawn --shift 10 --count 4 --out out/dawn
        worlds --mixture 28 --nulls 12 --seed 7 --out out/mixture"))]
    Worlds(WorldsArgs),
    /// Every statistic that the diagnosis reads, in made worlds and in real people, as quantiles.
    #[command(after_help = examples("realism --cohort out/hupa --cohort out/uom --seed 3 --out \
        out/realism"))]
    Realism(RealismArgs),
    /// What the diagnosis reads of worlds whose truth is known, or of cohorts: the table that a posterior is trained on.
    #[command(after_help = examples("evidence --worlds 252 --nulls 150 --seed 1 --out \
        out/evidence"))]
    Evidence(EvidenceArgs),
    /// Train the posterior of the diagnosis on tables of `evidence`, and one for each hand that has not seen it.
    #[command(after_help = examples("train-posterior --table out/evidence --out out/posterior"))]
    TrainPosterior(TrainPosteriorArgs),
    /// Write report.html for an output folder.
    #[command(after_help = examples("report out/pipeline"))]
    Report {
        /// An output folder of any command.
        folder: PathBuf,
    },
    /// Steady states of a model over glucose, with their residuals.
    #[command(after_help = examples("steady-state --model out/published/population.safetensors \
        --compare initSteadyStates.csv --out out/steady-state"))]
    SteadyState(SteadyStateArgs),
    /// Whether a model answers to insulin and carbohydrate as a person does: ladders of doses beside the ODE's.
    #[command(after_help = examples("trajectories --model out/train/population.safetensors
        trajectories --model out/published/population.safetensors --twin \
        out/published/twin.safetensors"))]
    Trajectories(TrajectoriesArgs),
    /// Hidden widths of the ten networks by Bayesian optimisation of the balanced error; goes on where it was ended.
    #[command(after_help = examples("widths
        widths --profile paper --explore 50 --exploit 50 --out out/widths"))]
    Widths(WidthsArgs),
    /// Errors and outcomes of a population network on held-out days of the development set, beside the ODE.
    #[command(after_help = examples("held-out --model out/train/population.safetensors
        held-out --model ours.safetensors --beside published.safetensors --profile paper"))]
    HeldOut(HeldOutArgs),
    /// How fast a diagnosis is, and how time and memory grow with the cohort; how fast training is.
    #[command(after_help = examples("bench
        bench --people 100 --effect none
        bench --what training-step"))]
    Bench(BenchArgs),
    /// Write what a shell needs to complete commands and options.
    #[command(after_help = examples("completions bash > t1d-twins.bash"))]
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

/// Examples of a command, one a line, as its help shows them.
fn examples(lines: &str) -> String {
    let program = pipeline::call_program("cargo xtask");
    let title = if lines.contains('\n') { "Examples:" } else { "Example:" };
    let typed = lines.lines().map(|line| format!("\n  {program} {}", line.trim_start()));
    typed.fold(title.to_owned(), |help, line| help + &line)
}

/// Options of `pipeline`.
#[derive(Debug, Args)]
pub(crate) struct PipelineArgs {
    /// How much to compute.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// Cohort folder [default: the embedded cohort].
    #[arg(long, value_name = "DIR")]
    pub cohort: Option<PathBuf>,
    /// Population model to use instead of training one.
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Virtual patients of whom the closest is taken, in the columns of the published population; 99
    /// of our own where it is not given.
    #[arg(long, value_name = "FILE")]
    pub patients: Option<PathBuf>,
    /// Compute this stage and all after it anew.
    #[arg(long, value_parser = one_of(STAGE), value_name = "STAGE")]
    pub from: Option<Stage>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/pipeline")]
    pub out: PathBuf,
    /// Seed of everything random.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `import`.
#[derive(Debug, Args)]
pub(crate) struct ImportArgs {
    /// Format of the source.
    #[arg(long, value_parser = words::cohort_format(), value_name = "FORMAT")]
    pub from: ImportFormat,
    /// The study's folder or file; for tables several are possible.
    #[arg(required = true)]
    pub source: Vec<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/import")]
    pub out: PathBuf,
    /// Write `records.parquet` in place of `records.csv`.
    #[arg(long)]
    pub parquet: bool,
    /// Which column is what: `time=COL,glucose=COL,...` (person, time or date and clock, glucose,
    /// basal, bolus, long_acting, carbs, heart_rate, steps, sleep, set_change; `FILE:COL` for a
    /// column of one file), or a TOML file.
    #[arg(long, value_name = "MAP")]
    pub map: Vec<String>,
    /// Units that are not mg/dL, U/h, U, g: `glucose=mmol/L,basal=U/5min,carbs=10 g`.
    #[arg(long, value_name = "UNITS")]
    pub unit: Vec<String>,
    /// Where the people lived, for times in UTC and daylight-saving time: `Europe/Madrid`.
    #[arg(long, value_name = "ZONE")]
    pub zone: Option<String>,
    /// Times without an offset are UTC.
    #[arg(long)]
    pub utc: bool,
    /// Order of day and month, where a table leaves it open.
    #[arg(long, value_parser = one_of(DATE_ORDER), value_name = "ORDER")]
    pub dates: Option<DateOrder>,
    /// The decimal mark, where a table leaves it open: `.` or `,`.
    #[arg(long, value_name = "MARK")]
    pub decimal: Option<char>,
    /// The sheet of an Excel workbook; without it the first.
    #[arg(long, value_name = "SHEET")]
    pub sheet: Option<String>,
    /// Propose a map of the tables, and write nothing.
    #[arg(long)]
    pub guess: bool,
}

/// What to do with a cohort folder.
#[derive(Debug, Subcommand)]
pub(crate) enum CohortCommand {
    /// List everything that is wrong with a folder, with row, column and remedy.
    Check {
        /// The cohort folder.
        folder: PathBuf,
    },
    /// Write a template with three example rows.
    New {
        /// The folder to make.
        folder: PathBuf,
    },
}

/// Options of `export`.
#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// Format to write.
    #[arg(long, value_parser = one_of(EXPORT_FORMAT), value_name = "FORMAT")]
    pub to: ExportFormat,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/export")]
    pub out: PathBuf,
}

/// Options of `simulate`.
#[derive(Debug, Args)]
pub(crate) struct SimulateArgs {
    /// Parameters of the patients, a row each.
    #[arg(long, value_name = "FILE")]
    pub patients: PathBuf,
    /// Meals: step and grams.
    #[arg(long, value_name = "FILE")]
    pub meals: PathBuf,
    /// Initial states, a row a patient [default: the steady state at 160 mg/dL].
    #[arg(long, value_name = "FILE")]
    pub initial: Option<PathBuf>,
    /// Days to simulate.
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub days: usize,
    /// One scenario by name [default: both].
    #[arg(long, value_name = "NAME")]
    pub scenario: Option<String>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/simulate")]
    pub out: PathBuf,
}

/// Options of `development-set`.
#[derive(Debug, Args)]
pub(crate) struct DevelopmentSetArgs {
    /// How many days: quick 420, paper 323,400 (two minutes, 3 GB).
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick", hide_possible_values = true)]
    pub profile: Profile,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/development-set")]
    pub out: PathBuf,
    /// Seed of meals, starts and doses.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `train`.
#[derive(Debug, Args)]
pub(crate) struct TrainArgs {
    /// How much to compute: the network's widths and the simulated days.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// How the network is trained.
    #[arg(long, value_parser = one_of(TRAINING_PRESET), default_value = "working")]
    pub preset: TrainingPreset,
    /// End after so many epochs without a lower error on the validation windows, and keep the best
    /// epoch's weights [default: all epochs].
    #[arg(long, value_name = "EPOCHS")]
    pub patience: Option<usize>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/train")]
    pub out: PathBuf,
    /// Seed of the simulated days, the initial weights and the order of the batches.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `import-model`.
#[derive(Debug, Args)]
pub(crate) struct ImportModelArgs {
    /// Format of the source.
    #[arg(long, value_parser = one_of(MODEL_FORMAT), value_name = "FORMAT")]
    pub from: ModelFormat,
    /// Folder of the published files.
    pub folder: PathBuf,
    /// Population model that a published twin belongs to [default: the published one in the folder
    /// above the twin's].
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/import-model")]
    pub out: PathBuf,
}

/// Options of `verify`.
#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// Box over which to verify [default: the range of the model's training data; an imported model has none].
    #[arg(long, value_name = "FILE")]
    pub region: Option<PathBuf>,
    /// Verify a person's twin on this population model in its place: insulin-action and glucose directions of dQ1/dt, over
    /// the ranges of the person's record.
    #[arg(long, value_name = "FILE", requires = "cohort", conflicts_with_all = ["region", "repair",
        "widen", "delta", "milp"])]
    pub twin: Option<PathBuf>,
    /// The cohort with that person's record.
    #[arg(long, value_name = "DIR", requires = "twin")]
    pub cohort: Option<PathBuf>,
    /// Widen every interval of the box at both ends by this share of its length: the paper's generalisation region.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub widen: f64,
    /// Longest step for the paper's z, scaled [default: ten times the smallest change of the input between simulated steps].
    #[arg(long, value_name = "DELTA")]
    pub delta: Option<f64>,
    /// Programme that HiGHS solves beside the certified search, for networks of up to four inputs.
    #[arg(long, value_parser = one_of(MILP_FORM), default_value = "gradient")]
    pub milp: MilpForm,
    /// Time limit of one row, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
    pub limit: f64,
    /// Change the model as little as it takes to have every physical property, and verify what comes out.
    #[arg(long)]
    pub repair: bool,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/verify")]
    pub out: PathBuf,
    /// Seed of the sampled share of the box.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `twin`.
#[derive(Debug, Args)]
pub(crate) struct TwinArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// How much to compute.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// Also train twins that see other personal inputs (the paper's ablation), and twins whose
    /// network keeps physiology's signs.
    #[arg(long)]
    pub variants: bool,
    /// Output folder of an earlier run, whose twins are trained further; say with `--training-days`
    /// how many days there are now.
    #[arg(long, value_name = "DIR")]
    pub continue_from: Option<PathBuf>,
    /// Days from the start of each record that train; the profile's 14 if not given.
    #[arg(long, value_name = "N")]
    pub training_days: Option<usize>,
    /// Passes over the windows; the profile's if not given. Further training needs fewer.
    #[arg(long, value_name = "N")]
    pub epochs: Option<usize>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/twin")]
    pub out: PathBuf,
    /// Seed of the initial weights and the order of the batches.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `baselines`.
#[derive(Debug, Args)]
pub(crate) struct BaselinesArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// Population model; its scaling of glucose enters the loss.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// The virtual patients of whom the closest is taken, in the columns of the published population;
    /// 99 of our own where it is not given.
    #[arg(long, value_name = "FILE")]
    pub patients: Option<PathBuf>,
    /// How much to compute.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// Days from the start of each record that train; 14 if not given.
    #[arg(long, value_name = "N")]
    pub training_days: Option<usize>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/baselines")]
    pub out: PathBuf,
    /// Seed of the search and of the sampler.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `replay`.
#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// A twin of that population model.
    #[arg(long, value_name = "FILE")]
    pub twin: Option<PathBuf>,
    /// `steady-state`, or `table:FILE` with scaled states by glucose.
    #[arg(long, value_parser = words::initial, value_name = "START", default_value = "steady-state")]
    pub initial: Initial,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/replay")]
    pub out: PathBuf,
}

/// Options of `reconcile`.
#[derive(Debug, Args)]
pub(crate) struct ReconcileArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// How meals are found.
    #[arg(long, value_parser = one_of(DETECTOR), value_name = "DETECTOR", default_value = "plant")]
    pub detector: DetectorName,
    /// How they and the log become one log.
    #[arg(long, value_parser = one_of(RULE), value_name = "RULE", default_value = "published")]
    pub rule: Rule,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/reconcile")]
    pub out: PathBuf,
}

/// Options of `evaluate`.
#[derive(Debug, Args)]
pub(crate) struct EvaluateArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// Output folder of `twin`.
    #[arg(long, value_name = "DIR")]
    pub twins: PathBuf,
    /// Output folder of `baselines`.
    #[arg(long, value_name = "DIR")]
    pub baselines: Option<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/evaluate")]
    pub out: PathBuf,
    /// Seed of the bootstrap.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `effect-twins`.
#[derive(Debug, Args)]
pub(crate) struct EffectTwinsArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// How much to compute.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/effect-twins")]
    pub out: PathBuf,
    /// Seed of weights, order, folds and bootstrap.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `diagnose`.
#[derive(Debug, Args)]
pub(crate) struct DiagnoseArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// The plant to diagnose: `ode`, the file of a population model or of a person's twin, or an output
    /// folder of the command twin.
    #[arg(long, value_name = "MODEL", default_value = "ode")]
    pub model: String,
    /// The population model that twins were trained on, if it does not lie beside them.
    #[arg(long, value_name = "FILE")]
    pub population: Option<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/diagnose")]
    pub out: PathBuf,
    /// Seed of the bootstrap.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// A posterior, as `train-posterior` writes it, in place of that in use.
    #[arg(long, value_name = "FILE", hide = true)]
    pub posterior: Option<PathBuf>,
}

/// Options of `blind-check`.
#[derive(Debug, Args)]
pub(crate) struct BlindCheckArgs {
    /// Worlds with one effect, two effects, or one outside the library [default: 28; 252 with
    /// --full].
    #[arg(long, value_name = "N")]
    pub worlds: Option<usize>,
    /// Worlds without an effect [default: 12; 150 with --full].
    #[arg(long, value_name = "N")]
    pub nulls: Option<usize>,
    /// As many worlds as it takes to test every target.
    #[arg(long)]
    pub full: bool,
    /// The plant that is asked: `ode`, or the file of a population model.
    #[arg(long, value_name = "MODEL", default_value = "ode")]
    pub model: String,
    /// In place of worlds: effects planted into the records of this cohort of real people.
    #[arg(long, value_name = "COHORT", conflicts_with_all = ["worlds", "nulls", "full", "model"])]
    pub planted: Option<PathBuf>,
    /// With --planted: multiples of each effect's usual size [default: 1,2].
    #[arg(long, value_name = "TIMES", value_delimiter = ',', requires = "planted")]
    pub sizes: Vec<f64>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/blind-check")]
    pub out: PathBuf,
    /// Seed of the worlds [default: a fresh one, which is said].
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

/// Options of `worlds`.
#[derive(Debug, Args)]
pub(crate) struct WorldsArgs {
    /// What acts: an effect, two of them joined by `+`, or `none`.
    #[arg(long, value_name = "NAME", default_value = "none")]
    pub effect: String,
    /// Mean absolute shift of glucose that each effect is to cause, mg/dL.
    #[arg(long, value_name = "MG_DL", default_value_t = 5.0)]
    pub shift: f64,
    /// Generator of the bodies: `hovorka`, `padova`, `minimal` or `saturating` [default: all in turns].
    #[arg(long, value_name = "NAME", value_parser = words::generator)]
    pub generator: Option<Generator>,
    /// How basal insulin is decided [default: drawn].
    #[arg(long, value_parser = one_of(REGIME), value_name = "REGIME")]
    pub regime: Option<RegimeName>,
    /// People in each world.
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub people: usize,
    /// Days of each.
    #[arg(long, value_name = "N", default_value_t = 14)]
    pub days: usize,
    /// Missing heart rates, gaps, uneven days and unlogged set changes as in a blind check.
    #[arg(long)]
    pub nuisances: bool,
    /// Worlds.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub count: usize,
    /// In place of one effect: this many worlds with effects, mixed as in a blind check.
    #[arg(long, value_name = "N", conflicts_with_all = ["effect", "shift", "regime", "people",
        "days", "nuisances", "count"])]
    pub mixture: Option<usize>,
    /// With --mixture: worlds without an effect.
    #[arg(long, value_name = "N", default_value_t = 0, requires = "mixture")]
    pub nulls: usize,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/worlds")]
    pub out: PathBuf,
    /// Seed of the worlds.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `realism`.
#[derive(Debug, Args)]
pub(crate) struct RealismArgs {
    /// A cohort of real people; may be given more than once.
    #[arg(long, value_name = "DIR", required = true)]
    pub cohort: Vec<PathBuf>,
    /// Worlds in which something is missing.
    #[arg(long, value_name = "N", default_value_t = 120)]
    pub worlds: usize,
    /// Worlds in which nothing is missing.
    #[arg(long, value_name = "N", default_value_t = 120)]
    pub nulls: usize,
    /// People in each world.
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub people: usize,
    /// Days of each person; of longer records those with the most readings.
    #[arg(long, value_name = "N", default_value_t = 14)]
    pub days: usize,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/realism")]
    pub out: PathBuf,
    /// Seed of the worlds.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `evidence`.
#[derive(Debug, Args)]
pub(crate) struct EvidenceArgs {
    /// Worlds in which something is missing.
    #[arg(long, value_name = "N", default_value_t = 252)]
    pub worlds: usize,
    /// Worlds in which nothing is missing.
    #[arg(long, value_name = "N", default_value_t = 150)]
    pub nulls: usize,
    /// Let everyday life vary as little as in the embedded cohort, and effects have their typical forms.
    #[arg(long, conflicts_with_all = ["cohort", "labelled"])]
    pub narrow: bool,
    /// Cohorts to be read in the place of worlds; may be given more than once.
    #[arg(long, value_name = "DIR")]
    pub cohort: Vec<PathBuf>,
    /// Worlds of another hand to be read in the place of ours: a folder with `worlds/` and `labels.json` (schema
    /// `blind_labels/1`); may be given more than once.
    #[arg(long, value_name = "DIR", conflicts_with = "cohort")]
    pub labelled: Vec<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/evidence")]
    pub out: PathBuf,
    /// Seed of the worlds.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `train-posterior`.
#[derive(Debug, Args)]
pub(crate) struct TrainPosteriorArgs {
    /// A table of `evidence`; may be given more than once.
    #[arg(long, value_name = "DIR", required = true)]
    pub table: Vec<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/posterior")]
    pub out: PathBuf,
    /// Seed of the networks.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `steady-state`.
#[derive(Debug, Args)]
pub(crate) struct SteadyStateArgs {
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// A table of scaled initial states by glucose to compare with.
    #[arg(long, value_name = "FILE")]
    pub compare: Option<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/steady-state")]
    pub out: PathBuf,
}

/// Options of `trajectories`.
#[derive(Debug, Args)]
pub(crate) struct TrajectoriesArgs {
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// A person's twin on that model.
    #[arg(long, value_name = "FILE")]
    pub twin: Option<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/trajectories")]
    pub out: PathBuf,
}

/// Options of `widths`.
#[derive(Debug, Args)]
pub(crate) struct WidthsArgs {
    /// How much each training computes.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// Trainings that explore the range of widths.
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub explore: usize,
    /// Trainings of widths that the trials before them propose.
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub exploit: usize,
    /// Trainings side by side while exploring; each takes some megabytes beside the common data.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub at_once: usize,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/widths")]
    pub out: PathBuf,
    /// Seed of simulated days, initial weights and proposals.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `held-out`.
#[derive(Debug, Args)]
pub(crate) struct HeldOutArgs {
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// Another population model, on the same windows.
    #[arg(long, value_name = "FILE")]
    pub beside: Option<PathBuf>,
    /// The development set whose test subset is used: that of `train` with this profile and seed.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// Seed of the development set.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/held-out")]
    pub out: PathBuf,
}

/// What `bench` times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum BenchSubject {
    /// The diagnosis of virtual people.
    Diagnosis,
    /// One update of the population network; takes no option but `--out` and `--seed`.
    TrainingStep,
    /// Training and running of twins; takes no option but `--out` and `--seed`.
    Twins,
    /// Meals found and logs reconciled against worlds' truth; takes no option but `--out` and `--seed`.
    Meals,
}

/// Options of `bench`.
#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    /// What is timed.
    #[arg(long, value_enum, default_value = "diagnosis")]
    pub what: BenchSubject,
    /// People of the largest cohort; a quarter and half of them are diagnosed before.
    #[arg(long, value_name = "N", default_value_t = 1_000)]
    pub people: usize,
    /// Days of each.
    #[arg(long, value_name = "N", default_value_t = 14)]
    pub days: usize,
    /// What acts in everybody: an effect, or `none`. Every effect that is named costs another round.
    #[arg(long, value_name = "NAME", default_value = "dawn")]
    pub effect: String,
    /// Its amplitude; 1 is the published size.
    #[arg(long, value_name = "SIZE", default_value_t = 1.0)]
    pub amplitude: f64,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/bench")]
    pub out: PathBuf,
    /// Seed of the people and of the bootstrap.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}
