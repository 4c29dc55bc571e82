//! Which crate may know which: the arrows of `docs/architecture.md`, checked against the manifests.

mod circles;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context as _, Result, ensure};

/// Each crate with the crates of this workspace that it may depend on.
///
/// `reference-data` is for tests and may be a development dependency of any crate.
const ALLOWED: &[(&str, &str)] = &[
    ("named", ""),
    ("physiology", "named"),
    ("reference-data", ""),
    ("contract", "named"),
    ("ode-sim", "named physiology"),
    ("nn-statespace", "physiology"),
    ("conformance", "contract"),
    ("certificate", ""),
    ("cohort", "named contract physiology"),
    ("stats", "contract physiology"),
    ("bayesopt", ""),
    ("behaviour", "contract physiology"),
    ("twins", "named physiology ode-sim nn-statespace cohort"),
    ("ode-twins", "contract physiology ode-sim nn-statespace cohort stats bayesopt twins"),
    ("evaluation", "named contract physiology ode-sim nn-statespace cohort stats twins"),
    ("world", "named physiology ode-sim cohort"),
    ("effects", "named"),
    ("gap", "named contract physiology ode-sim cohort stats effects posterior"),
    ("posterior", "contract"),
    ("blind", "contract stats"),
    ("meals", "contract physiology ode-sim cohort"),
    ("report", "contract"),
    ("plants", "physiology ode-sim nn-statespace cohort stats twins effects gap"),
    ("development", "contract physiology ode-sim nn-statespace conformance stats bayesopt"),
    (
        "bench",
        "pipeline contract physiology ode-sim nn-statespace cohort twins effects gap meals world",
    ),
    ("fuzz-targets", "contract nn-statespace conformance certificate cohort twins"),
    ("cli", "pipeline bench"),
    ("xtask", "cli"),
];

/// The crate that may know every crate that computes.
const TOP: &str = "pipeline";
/// The crates above it.
const ABOVE: [&str; 3] = ["bench", "cli", "xtask"];

/// Reads `cargo metadata` of the workspace at `root` and reports every arrow that is not allowed.
pub(crate) fn check(root: &Path) -> Result<()> {
    let output = std::process::Command::new("cargo")
        .args(["metadata", "--no-deps", "--format-version", "1", "--locked"])
        .current_dir(root)
        .output()
        .context("cannot run cargo metadata")?;
    let errors = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "cargo metadata failed: {}", errors.trim());
    let metadata: serde_json::Value =
        serde_json::from_slice(&output.stdout).context("cargo metadata did not print JSON")?;
    let wrong = forbidden_arrows(&arrows(&metadata));
    ensure!(
        wrong.is_empty(),
        "crates depend on what they must not know (docs/architecture.md): {}",
        wrong.join(", ")
    );
    circles::check(root)
}

/// Crate to the workspace crates it names in `[dependencies]`.
fn arrows(metadata: &serde_json::Value) -> BTreeMap<String, BTreeSet<String>> {
    let packages = metadata["packages"].as_array().map_or(&[][..], Vec::as_slice);
    let names: BTreeSet<&str> = packages.iter().filter_map(|p| p["name"].as_str()).collect();
    let known = |package: &serde_json::Value| {
        let dependencies = package["dependencies"].as_array()?.iter();
        let needed = dependencies.filter(|d| d["kind"].is_null());
        let known = needed.filter_map(|d| d["name"].as_str()).filter(|name| names.contains(name));
        Some((package["name"].as_str()?.to_owned(), known.map(str::to_owned).collect()))
    };
    packages.iter().filter_map(known).collect()
}

fn forbidden_arrows(arrows: &BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    let mut wrong = Vec::new();
    for (from, targets) in arrows {
        let may_know = ALLOWED.iter().find(|(name, _)| name == from).map(|(_, names)| *names);
        let forbidden = |to: &&String| match may_know {
            Some(names) => !names.split(' ').any(|name| name == *to),
            None => ABOVE.contains(&to.as_str()),
        };
        if may_know.is_none() && from != TOP {
            wrong.push(format!("{from} (not listed)"));
        } else {
            wrong.extend(targets.iter().filter(forbidden).map(|to| format!("{from} -> {to}")));
        }
    }
    wrong
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(names: &[&str]) -> BTreeSet<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn a_plant_that_knows_the_other_plant_is_named() {
        let arrows = BTreeMap::from([
            ("ode-sim".to_owned(), set(&["physiology", "nn-statespace"])),
            ("pipeline".to_owned(), set(&["ode-sim", "nn-statespace"])),
        ]);
        assert_eq!(forbidden_arrows(&arrows), ["ode-sim -> nn-statespace"]);
    }

    #[test]
    fn a_stage_that_knows_the_command_line_is_named() {
        let arrows = BTreeMap::from([("pipeline".to_owned(), set(&["cli", "stats"]))]);
        assert_eq!(forbidden_arrows(&arrows), ["pipeline -> cli"]);
    }

    #[test]
    fn a_new_crate_must_be_listed() {
        let arrows = BTreeMap::from([("surprise".to_owned(), set(&[]))]);
        assert_eq!(forbidden_arrows(&arrows), ["surprise (not listed)"]);
    }

    #[test]
    fn the_workspace_keeps_its_directions() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        check(&root).expect("directions as documented");
    }
}
