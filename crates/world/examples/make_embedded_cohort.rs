//! Writes the embedded cohort: `OUT_DIR/cohort` and, apart from it, `OUT_DIR/info.json` with its
//! provenance, the checks made and the truth behind it.
//!
//!     cargo run -p world --example make_embedded_cohort -- OUT_DIR
#![expect(clippy::print_stdout, reason = "an example tells what it wrote")]

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use cohort::{RecordsFormat, read_folder, write_folder};
use serde_json::json;
use world::{EMBEDDED_SEED, embedded_cohort, plausibility};

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args_os()
        .nth(1)
        .map(PathBuf::from)
        .ok_or("no folder given; usage: make_embedded_cohort OUT_DIR")?;
    let folder = out.join("cohort");
    let (cohort, world) = embedded_cohort(EMBEDDED_SEED)?;

    let mut checks = serde_json::Map::new();
    for person in &cohort.people {
        let made = plausibility::checks(&person.record);
        if let Some(check) = made.iter().find(|check| !check.holds()) {
            return Err(format!("{}: {check:?} is not plausible", person.id).into());
        }
        let figures: serde_json::Map<_, _> = made
            .iter()
            .map(|check| {
                let value = (10.0 * check.value).round() / 10.0;
                let range = [check.lowest, check.highest];
                (
                    check.figure.to_owned(),
                    json!({ "value": value, "unit": check.unit, "range": range }),
                )
            })
            .collect();
        checks.insert(person.id.clone(), figures.into());
    }

    fs::create_dir_all(&out)?;
    write_folder(&cohort, &folder, RecordsFormat::Parquet)?;
    if read_folder(&folder)? != cohort {
        return Err("the cohort does not read back as it was written".into());
    }
    let info = json!({
        "origin": "made by the crate `world` of this repository; no data of any person",
        "command": "cargo run -p world --example make_embedded_cohort -- OUT_DIR",
        "seed": EMBEDDED_SEED,
        "versions": { "world": world.version },
        "licence": env!("CARGO_PKG_LICENSE"),
        "checks": {
            "reads_back_equal": true,
            "plausibility": checks,
        },
        "world": world,
    });
    fs::write(out.join("info.json"), format!("{info:#}\n"))?;

    for entry in fs::read_dir(&folder)? {
        let entry = entry?;
        println!("{}: {} bytes", entry.path().display(), entry.metadata()?.len());
    }
    println!("{}: provenance, checks and labels", out.join("info.json").display());
    Ok(())
}
