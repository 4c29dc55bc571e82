//! A workspace outside of this one that imports single crates by path, as a downstream tool does.
//!
//! It is written into a temporary folder, built and run. What compiles here alone because of features that other crates
//! switch on, or of paths that only the workspace has, fails there.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, ensure};

/// The crates that are imported: those that build without HiGHS and polars.
const IMPORTED: &str = "behaviour contract effects nn-statespace ode-sim physiology report stats";

/// A program that calls each of them once.
const PROGRAM: &str = r##"
use physiology::{MgPerDl, OpenLoop, Plant as _, StepInput, simulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let network = nn_statespace::PopulationModel::shipped()?;
    let held = nn_statespace::initial_state::steady_state(&network, MgPerDl(120.0))?;
    let inputs = vec![StepInput { basal: held.basal, ..StepInput::default() }; 12];
    let run = simulate(&network, held.states, &mut OpenLoop::new(&inputs), inputs.len())?;
    let glucose: Vec<MgPerDl> = run.states.iter().map(|state| network.glucose(state)).collect();
    let outcomes = stats::Outcomes::of(glucose)?;
    assert!(outcomes.get(stats::Outcome::Tir) > 99.0);
    assert!(ode_sim::OdeParameters::nominal().s_f1 > 0.0);
    assert!(effects::library().iter().any(|effect| effect.card().id.name() == "dawn"));
    let twins: contract::TwinsTable = contract::read(br#"{"schema": "twins/1", "people": []}"#)?;
    let mut inputs = report::Inputs::default();
    inputs.read(report::Part::Twins, serde_json::to_vec(&twins)?.as_slice())?;
    assert!(report::render(&inputs)?.contains(report::DISCLAIMER));
    assert_ne!(behaviour::Check::Basal, behaviour::Check::Bolus);
    Ok(())
}
"##;

/// Builds and runs the workspace in `folder`; dependencies are those of the lock file of `root`.
fn build(root: &Path, folder: &Path) -> Result<()> {
    let place = root.canonicalize().context("the workspace")?;
    let mut manifest = String::from(
        "[package]\nname = \"outside\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n[workspace]\n\n\
         [profile.dev]\ndebug = false\n\n[dependencies]\n\
         serde_json = \"1\"\n",
    );
    for name in IMPORTED.split(' ') {
        let path = place.join("crates").join(name);
        manifest.push_str(&format!("{name} = {{ path = {path:?} }}\n"));
    }
    fs::create_dir_all(folder.join("src")).context("a temporary folder")?;
    fs::write(folder.join("Cargo.toml"), manifest)?;
    fs::write(folder.join("src/main.rs"), PROGRAM)?;
    fs::copy(place.join("Cargo.lock"), folder.join("Cargo.lock")).context("the lock file")?;
    let status = Command::new("cargo")
        .args(["run", "--quiet", "--offline"])
        .current_dir(folder)
        .env("CARGO_TARGET_DIR", place.join("target/outside"))
        .status()
        .context("cannot run cargo")?;
    let names = IMPORTED.replace(' ', ", ");
    ensure!(status.success(), "a workspace outside that imports {names} fails");
    Ok(())
}

/// Writes, builds and runs it.
pub(crate) fn check(root: &Path) -> Result<()> {
    let folder = std::env::temp_dir().join(format!("outside-{}", std::process::id()));
    let built = build(root, &folder);
    // A folder that stays is no reason to fail.
    let _ = fs::remove_dir_all(&folder);
    built
}
