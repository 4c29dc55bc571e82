//! The command line: every command from a study's files to the report.
//!
//! The binary `t1d-twins` of this crate is what a user installs (`cargo install --path crates/cli`); `cargo xtask`
//! hands everything but `check` and `same` to the same [`run`]. What was typed becomes the settings of a stage of `pipeline`.

mod cli;
mod numbers;
mod settings;

use std::io::{ErrorKind, Write as _};
use std::process::ExitCode;

use anyhow::{Context as _, Result};
use clap::{CommandFactory as _, FromArgMatches as _};

pub use pipeline::note;
use pipeline::stages;

use cli::{
    BenchArgs, BenchSubject, BlindCheckArgs, CohortCommand, Command, CommandLine, VerifyArgs,
};

/// Most threads that can be asked for; more would only wait for each other.
const MOST_THREADS: usize = 1024;

/// Every command with its options; `program` is the name in help, examples and manifests.
#[must_use]
pub fn commands(program: &'static str) -> clap::Command {
    // Examples of the help ask for it.
    let program = pipeline::call_program(program);
    CommandLine::command()
        .name(program)
        .bin_name(program)
        .mut_args(numbers::read_in_words)
        .mut_subcommands(|command| command.mut_args(numbers::read_in_words))
}

/// Runs what was typed. An error is one message on the standard error stream and exit status 1; clap has already
/// ended the program with status 2 on wrong usage.
#[must_use]
pub fn run(typed: &clap::ArgMatches) -> ExitCode {
    quiet_caught_panics();
    let line = CommandLine::from_arg_matches(typed).unwrap_or_else(|error| error.exit());
    let done = perform(line, typed.subcommand_name().unwrap_or_default());
    if done.is_ok() {
        pipeline::say_next();
    }
    ended(done)
}

/// The exit status of a command; an error is said in one message.
#[must_use]
pub fn ended(result: Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            pipeline::say(&format!("error: {}", pipeline::in_words(&error)));
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

/// Writes the completions of a shell to the standard output.
fn completions(shell: clap_complete::Shell) -> Result<()> {
    let program = "t1d-twins";
    let mut text: Vec<u8> = Vec::new();
    clap_complete::generate(shell, &mut commands(program), program, &mut text);
    let mut out = std::io::stdout().lock();
    match out.write_all(&text).and_then(|()| out.flush()) {
        // That nobody reads on is no fault.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.context("cannot write the completions"),
    }
}

/// Runs a command line whose command is called `command`.
fn perform(line: CommandLine, command: &str) -> Result<()> {
    if line.json {
        anyhow::ensure!(
            pipeline::result_file(command).is_some(),
            "--json: the result of '{command}' is no JSON; its files are in the output folder"
        );
        pipeline::ask_for_json();
    }
    if line.quiet {
        pipeline::be_quiet();
    }
    if let Some(threads) = line.threads {
        pipeline::bounds::within("--threads", threads, 1, MOST_THREADS)?;
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()
            .context("cannot start the threads")?;
    }
    match line.command {
        Command::Pipeline(args) => stages::pipeline::run(&args.into()),
        Command::Import(args) => stages::import::run(&args.into()),
        Command::Export(args) => stages::export::run(&args.into()),
        Command::Cohort(CohortCommand::Check { folder }) => stages::cohort_folder::check(&folder),
        Command::Cohort(CohortCommand::New { folder }) => stages::cohort_folder::new(&folder),
        Command::Simulate(args) => stages::simulate::run(&args.into()),
        Command::DevelopmentSet(args) => stages::development_set::run(&args.into()),
        Command::Train(args) => stages::train::run(&args.into()),
        Command::ImportModel(args) => stages::import_model::run(&args.into()),
        Command::Verify(args) => verify(args),
        Command::Twin(args) => stages::twin::run(&args.into()),
        Command::Baselines(args) => stages::baselines::run(&args.into()),
        Command::Replay(args) => stages::replay::run(&args.into()),
        Command::Reconcile(args) => stages::reconcile::run(&args.into()),
        Command::Evaluate(args) => stages::evaluate::run(&args.into()),
        Command::Diagnose(args) => stages::diagnose::run(&args.into()),
        Command::EffectTwins(args) => stages::effect_twins::run(&args.into()),
        Command::BlindCheck(args) => blind_check(args),
        Command::Evidence(args) => stages::evidence::run(&args.into()),
        Command::TrainPosterior(args) => stages::train_posterior::run(&args.into()),
        Command::Realism(args) => stages::realism::run(&args.into()),
        Command::Worlds(args) => stages::worlds::run(&args.into()),
        Command::Report { folder } => stages::report::run(&stages::report::Settings { folder }),
        Command::SteadyState(args) => stages::steady_state::run(&args.into()),
        Command::HeldOut(args) => stages::held_out::run(&args.into()),
        Command::Widths(args) => stages::widths::run(&args.into()),
        Command::Trajectories(args) => stages::trajectories::run(&args.into()),
        Command::Bench(args) => bench(args),
        Command::Completions { shell } => completions(shell),
    }
}

/// A person's twin is verified otherwise than a population network.
fn verify(args: VerifyArgs) -> Result<()> {
    let (Some(twin), Some(cohort)) = (args.twin.clone(), args.cohort.clone()) else {
        return stages::verify::run(&args.into());
    };
    let VerifyArgs { model, limit, out, seed, .. } = args;
    let settings = stages::verify_twin::Settings { model, twin, cohort, limit, out, seed };
    stages::verify_twin::run(&settings)
}

/// Effects planted into real records are checked otherwise than those of worlds, and finished checks are scored together.
fn blind_check(args: BlindCheckArgs) -> Result<()> {
    if !args.together.is_empty() {
        let BlindCheckArgs { together: checks, out, .. } = args;
        return stages::checks_together::run(&stages::checks_together::Settings { checks, out });
    }
    let Some(cohort) = args.planted.clone() else {
        return stages::blind_check::run(&args.into());
    };
    let BlindCheckArgs { sizes, out, seed, .. } = args;
    stages::planted_check::run(&stages::planted_check::Settings { cohort, sizes, out, seed })
}

fn bench(args: BenchArgs) -> Result<()> {
    let BenchArgs { what, people, days, effect, amplitude, out, seed } = args;
    match what {
        BenchSubject::Diagnosis => {
            let settings =
                bench::diagnosis::Settings { people, days, effect, amplitude, out, seed };
            bench::diagnosis::run(&settings)
        }
        BenchSubject::TrainingStep => bench::training_step::run(&out, seed),
        BenchSubject::Twins => bench::twin_speed::run(&out, seed),
        BenchSubject::Meals => bench::meal_detection::run(&out, seed),
    }
}
