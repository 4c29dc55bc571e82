//! `cargo xtask`: every command of the crate `cli`, and what developers need beside: `check` and `same`.

mod check;
mod directions;
mod outside;
mod same;

use std::process::ExitCode;

use check::CheckArgs;
use clap::{Args, Command};
use same::SameArgs;

fn main() -> ExitCode {
    let check = Command::new("check")
        .after_help("Examples:\n  cargo xtask check\n  cargo xtask check --static");
    let same = Command::new("same").after_help("Example:\n  cargo xtask same out/before out/after");
    let all = cli::commands("cargo xtask")
        .subcommand(CheckArgs::augment_args(check))
        .subcommand(SameArgs::augment_args(same));
    let typed = all.get_matches();
    match typed.subcommand() {
        Some(("check", options)) => cli::ended(check::run(&read::<CheckArgs>(options))),
        Some(("same", options)) => cli::ended(same::run(&read::<SameArgs>(options))),
        _ => cli::run(&typed),
    }
}

/// The options of a command as clap read them.
fn read<T: Args>(options: &clap::ArgMatches) -> T {
    T::from_arg_matches(options).unwrap_or_else(|error| error.exit())
}
