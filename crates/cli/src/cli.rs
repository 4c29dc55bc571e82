//! What was typed: the commands and their options.
//!
//! This file only describes the words; what they mean to a stage says `settings`.

mod cohorts;
mod diagnosis;
mod population;
mod twins;
mod words;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use pipeline::Profile;
use pipeline::stages::pipeline::Stage;

use self::words::{PROFILE, STAGE, one_of};

pub(crate) use self::cohorts::{
    CohortCommand, ExportArgs, ImportArgs, ReconcileArgs, SimulateArgs,
};
pub(crate) use self::diagnosis::{
    BlindCheckArgs, DiagnoseArgs, EvidenceArgs, RealismArgs, TrainPosteriorArgs, WorldsArgs,
};
pub(crate) use self::population::{
    DevelopmentSetArgs, HeldOutArgs, ImportModelArgs, SteadyStateArgs, TrainArgs, TrajectoriesArgs,
    VerifyArgs, WidthsArgs,
};
pub(crate) use self::twins::{BaselinesArgs, EffectTwinsArgs, EvaluateArgs, ReplayArgs, TwinArgs};

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
        blind-check --worlds 7 --nulls 3 --seed 5
        blind-check --together out/blind-1 --together out/blind-2 --out out/blind-both"))]
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
