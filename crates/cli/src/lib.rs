//! The command line: every command from a study's files to the report.
//!
//! The binary `t1d-twins` of this crate is what a user installs (`cargo install --path crates/cli`); `cargo xtask`
//! hands everything but `check` to the same [`run`]. This is the only crate that opens files for the user.

mod asked;
mod checkpoint;
mod children;
mod cli;
mod diagnosed;
mod inputs;
mod interrupt;
mod labels;
mod manifest;
mod models;
mod output;
mod paper_conformance;
mod progress;
mod stages;
mod subnetworks;
mod training_data;

use std::process::ExitCode;
use std::sync::OnceLock;

use anyhow::{Context as _, Result};
use clap::{CommandFactory as _, FromArgMatches as _};

use cli::{BenchSubject, Command, CommandLine};
pub use progress::note;

/// Most threads that can be asked for; more would only wait for each other.
const MOST_THREADS: usize = 1024;
/// What the examples of the help call the program.
const EXAMPLES: &str = "cargo xtask";

/// What the program is called, for help and manifests.
static PROGRAM: OnceLock<&'static str> = OnceLock::new();

/// The name under which the program was started.
pub(crate) fn program() -> &'static str {
    PROGRAM.get().copied().unwrap_or(EXAMPLES)
}

/// Every command with its options; `program` is the name in help, examples and manifests.
#[must_use]
pub fn commands(program: &'static str) -> clap::Command {
    let program = *PROGRAM.get_or_init(|| program);
    let renamed = |command: clap::Command| {
        let help = command.get_after_help().map(|help| help.to_string().replace(EXAMPLES, program));
        match help {
            Some(help) => command.after_help(help),
            None => command,
        }
    };
    CommandLine::command().name(program).bin_name(program).mut_subcommands(renamed)
}

/// Runs what was typed. An error is one message on the standard error stream and exit status 1; clap has already
/// ended the program with status 2 on wrong usage.
#[must_use]
pub fn run(typed: &clap::ArgMatches) -> ExitCode {
    quiet_caught_panics();
    let line = CommandLine::from_arg_matches(typed).unwrap_or_else(|error| error.exit());
    ended(perform(line))
}

/// The exit status of a command; an error is said in one message.
#[must_use]
pub fn ended(result: Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            progress::say(&format!("error: {error:#}"));
            ExitCode::FAILURE
        }
    }
}

/// The table library panics on some damaged Parquet files; the cohort's reader catches that and
/// says in words what is wrong. The panic's own message would only confuse.
fn quiet_caught_panics() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let from_tables = panic.location().is_some_and(|place| place.file().contains("polars"));
        if !from_tables {
            usual(panic);
        }
    }));
}

fn perform(line: CommandLine) -> Result<()> {
    if line.quiet {
        progress::be_quiet();
    }
    if let Some(threads) = line.threads {
        anyhow::ensure!(
            (1..=MOST_THREADS).contains(&threads),
            "--threads {threads} must be from 1 to {MOST_THREADS}"
        );
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()
            .context("cannot start the threads")?;
    }
    match line.command {
        Command::Pipeline(args) => stages::pipeline::run(&args),
        Command::Import(args) => stages::import::run(&args),
        Command::Simulate(args) => stages::simulate::run(&args),
        Command::DevelopmentSet(args) => stages::development_set::run(&args),
        Command::Train(args) => stages::train::run(&args),
        Command::ImportModel(args) => stages::import_model::run(&args),
        Command::Verify(args) => stages::verify::run(&args),
        Command::Twin(args) => stages::twin::run(&args),
        Command::Baselines(args) => stages::baselines::run(&args),
        Command::Replay(args) => stages::replay::run(&args),
        Command::Reconcile(args) => stages::reconcile::run(&args),
        Command::Evaluate(args) => stages::evaluate::run(&args),
        Command::Diagnose(args) => stages::diagnose::run(&args),
        Command::EffectTwins(args) => stages::effect_twins::run(&args),
        Command::BlindCheck(args) => stages::blind_check::run(&args),
        Command::Evidence(args) => stages::evidence::run(&args),
        Command::TrainPosterior(args) => stages::train_posterior::run(&args),
        Command::Realism(args) => stages::realism::run(&args),
        Command::Worlds(args) => stages::worlds::run(&args),
        Command::Report(args) => stages::report::run(&args),
        Command::SteadyState(args) => stages::steady_state::run(&args),
        Command::HeldOut(args) => stages::held_out::run(&args),
        Command::Widths(args) => stages::widths::run(&args),
        Command::Trajectories(args) => stages::trajectories::run(&args),
        Command::Bench(args) => match args.what {
            BenchSubject::Diagnosis => stages::bench::run(&args),
            BenchSubject::TrainingStep => stages::training_step::run(&args),
            BenchSubject::Twins => stages::twin_speed::run(&args),
            BenchSubject::Meals => stages::meals_bench::run(&args),
        },
    }
}

/// The folder of the workspace's `Cargo.toml` when this program was built.
pub(crate) fn workspace_root() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}
