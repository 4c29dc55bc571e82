//! The command line and the pipeline's stages: the only crate that opens files for the user.

mod asked;
mod bodies;
mod checkpoint;
mod cli;
mod development_data;
mod diagnosed;
mod directions;
mod effect_input;
mod held_out_windows;
mod inputs;
mod interrupt;
mod labels;
mod manifest;
mod models;
mod output;
mod paper_conformance;
mod progress;
mod simulated_steps;
mod stages;
mod training_data;
mod trajectory_cost;
mod width_search;

use std::process::ExitCode;

use anyhow::{Context as _, Result};
use clap::Parser as _;

use cli::{BenchSubject, Command, CommandLine};

/// Most threads that can be asked for; more would only wait for each other.
const MOST_THREADS: usize = 1024;

fn main() -> ExitCode {
    quiet_caught_panics();
    // clap prints its own message and ends with status 2 on wrong usage.
    let line = CommandLine::parse();
    match run(line) {
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

fn run(line: CommandLine) -> Result<()> {
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
        Command::Check(args) => stages::check::run(&args),
        Command::Bench(args) => match args.what {
            BenchSubject::Diagnosis => stages::bench::run(&args),
            BenchSubject::TrainingStep => stages::training_step::run(&args),
            BenchSubject::Twins => stages::twin_speed::run(&args),
            BenchSubject::Meals => stages::meals_bench::run(&args),
        },
    }
}
