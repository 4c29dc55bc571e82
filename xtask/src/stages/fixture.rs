//! `fixture`: the embedded cohort, made again from its seed.

use anyhow::{Context as _, Result};
use cohort::{MassBalance, RecordsFormat, write_folder};
use world::{EMBEDDED_DAYS, EMBEDDED_SEED, embedded_cohort};

use crate::cli::FixtureArgs;
use crate::manifest::Manifest;
use crate::output::OutputFolder;
use crate::progress::note;

/// Runs the command.
pub(crate) fn run(args: &FixtureArgs) -> Result<()> {
    let (cohort, info) = embedded_cohort(EMBEDDED_SEED).context("making the embedded cohort")?;
    let config = serde_json::json!({ "people": cohort.people.len(), "days": EMBEDDED_DAYS });
    let manifest = Manifest::new("fixture", config, Some(EMBEDDED_SEED));
    let output = OutputFolder::begin(&args.out)?;
    write_folder(&cohort, &output.path().join("cohort"), RecordsFormat::Parquet)
        .context("writing the cohort")?;
    output.write_json("world.json", &info)?;
    output.write_json(
        "info.json",
        &serde_json::json!({
            "origin": "made by the crate world of this project; no person's data",
            "command": "cargo xtask fixture --out fixtures/embedded",
            "seed": EMBEDDED_SEED,
            "version": env!("CARGO_PKG_VERSION"),
            "licence": "MIT",
            "checks": "plausibility, determinism and mass balance: crates/world/tests",
            "labels": "world.json lies apart from the cohort folder; the diagnosis is given the cohort folder only",
        }),
    )?;
    let place = output.finish(&manifest)?;
    for person in &cohort.people {
        note(MassBalance::of(person).to_string());
    }
    note(format!("fixture: {}", place.display()));
    Ok(())
}
