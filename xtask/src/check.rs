//! `check`: what continuous integration runs.

use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, ensure};
use clap::Args;

use cli::note;

use crate::{directions, outside};

/// Formatting, lints, crate directions, documentation and tests.
#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// Everything but the tests.
    #[arg(long = "static")]
    pub only_static: bool,
}

/// A step: its name, and the cargo arguments that run it.
type Step = (&'static str, &'static str);

/// Everything but the tests.
const STATIC_STEPS: [Step; 3] = [
    ("formatting", "fmt --all --check"),
    ("lints", "clippy --workspace --all-targets --locked --quiet -- --deny warnings"),
    ("documentation", "doc --workspace --no-deps --locked --quiet"),
];
const TESTS: Step = ("tests", "test --workspace --locked");

/// Runs the steps in order and stops at the first that fails.
pub(crate) fn run(args: &CheckArgs) -> Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    note("check: crate directions");
    directions::check(&root)?;
    for step in STATIC_STEPS {
        cargo(&root, step)?;
    }
    note("check: a workspace outside that imports single crates");
    outside::check(&root)?;
    if !args.only_static {
        cargo(&root, TESTS)?;
    }
    note("check: all passed");
    Ok(())
}

fn cargo(root: &Path, (name, arguments): Step) -> Result<()> {
    note(format!("check: {name} (cargo {arguments})"));
    // `cargo doc` has no option for flags of rustdoc, so they come from the environment.
    let flags = arguments.starts_with("doc ").then_some(("RUSTDOCFLAGS", "--deny warnings"));
    let status = Command::new("cargo")
        .args(arguments.split(' '))
        .envs(flags)
        .current_dir(root)
        .status()
        .with_context(|| format!("cannot run cargo {arguments}"))?;
    ensure!(status.success(), "{name} did not pass");
    Ok(())
}
