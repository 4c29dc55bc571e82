//! The shipped population network, and the commands that judge and shape networks.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use conformance::{Direction, PropertyKind, paper_properties};
use nn_statespace::structure::{SlopeSign, slope_sign};
use nn_statespace::{Signal, Wiring};
use physiology::Compartment;
use serde_json::Value;

fn start(arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
        .args(arguments)
        .arg("-q")
        .stderr(Stdio::inherit())
        .spawn()
        .expect("the program starts")
}

fn run(arguments: &[&str]) {
    let status = start(arguments).wait().expect("it ends");
    assert!(status.success(), "{arguments:?}");
}

fn text(path: &Path) -> &str {
    path.to_str().expect("temporary paths are UTF-8")
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("written")).expect("JSON")
}

fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../nn-statespace/model/population.safetensors")
}

/// Verdicts on the physical properties of a `conformance.json`.
fn physical(path: &Path) -> Vec<String> {
    let rows = json(path)["rows"].as_array().expect("rows").clone();
    let physical = rows.into_iter().filter(|row| row["kind"] == "physical");
    physical.map(|row| row["verdict"].as_str().expect("a verdict").to_owned()).collect()
}

#[test]
fn training_keeps_the_signs_that_are_proved() {
    let wiring = Wiring::paper();
    let mut compared = 0;
    for property in paper_properties() {
        if property.kind != PropertyKind::Physical {
            continue;
        }
        let network = Compartment::from_name(&property.network).expect("a compartment");
        let input = Signal::from_name(&property.input).expect("a signal");
        assert!(wiring.inputs(network).contains(&input));
        let expected = match property.direction {
            Direction::Increasing => SlopeSign::Rising,
            Direction::Decreasing => SlopeSign::Falling,
        };
        assert_eq!(slope_sign(network, input), expected, "{network} by {input}");
        compared += 1;
    }
    assert_eq!(compared, 25);
}

#[test]
fn the_shipped_network_behaves_and_every_physical_property_is_proved() {
    let folder = tempfile::tempdir().expect("a folder");
    let (model, out) = (shipped(), folder.path().join("trajectories"));
    run(&["trajectories", "--model", text(&model), "--out", text(&out)]);
    let found = json(&out.join("trajectories.json"));
    assert_eq!(found["passed"], Value::Bool(true), "{found:#}");
    assert_eq!(found["findings"].as_array().map(Vec::len), Some(5));

    let out = folder.path().join("verify");
    run(&["verify", "--model", text(&model), "--out", text(&out)]);
    assert_eq!(physical(&out.join("conformance.json")), vec!["proved"; 25]);
    assert!(crate::outputs::checked(folder.path()) >= 5);
}

#[test]
fn a_network_trained_without_constraints_is_repaired_to_the_same_bytes_by_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = |name: &str| folder.path().join(name);
    let (trained, first, second) = (out("trained"), out("first"), out("second"));
    run(&["train", "--preset", "unconstrained", "--seed", "3", "--out", text(&trained)]);
    let model = trained.join("population.safetensors");
    run(&["verify", "--model", text(&model), "--out", text(&out("before"))]);
    let before = physical(&out("before").join("conformance.json"));
    assert!(before.iter().any(|verdict| verdict == "violated"), "nothing to repair");
    for (out, threads) in [(&first, "1"), (&second, "2")] {
        let arguments = ["verify", "--repair", "--model", text(&model), "--threads", threads];
        run(&[arguments.as_slice(), &["--out", text(out)]].concat());
    }
    assert_eq!(physical(&first.join("conformance.json")), vec!["proved"; 25]);
    let told = json(&first.join("repair.json"));
    assert_eq!(told["proved"], Value::Bool(true));
    let error = &told["held_out_balanced_error_mg_dl"];
    assert!(error["after"].as_f64() > Some(0.0), "{error}");
    for file in ["population.safetensors", "repair.json"] {
        let read = |folder: &Path| fs::read(folder.join(file)).expect("written");
        assert!(read(&first) == read(&second), "{file} depends on the number of threads");
    }
    assert_eq!(crate::outputs::checked(&first), 5, "rows, proofs, repair, region, manifest");
}

#[test]
fn the_shipped_network_is_nearer_to_the_ode_than_the_published_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let (model, out) = (shipped(), folder.path().join("held-out"));
    let mut arguments = vec!["held-out", "--model", text(&model), "--out", text(&out)];
    let imported = folder.path().join("published");
    let name = "the_shipped_network_is_nearer_to_the_ode_than_the_published_one";
    let published = reference_data::find("t1dsim_ai", name).map(|place| {
        run(&["import-model", "--from", "t1dsim", text(&place), "--out", text(&imported)]);
        imported.join("population.safetensors")
    });
    if let Some(published) = &published {
        arguments.extend(["--beside", text(published)]);
    }
    run(&arguments);
    assert_eq!(crate::outputs::checked(&out), 2, "errors, manifest");
    let found = json(&out.join("held-out.json"));
    let errors = |model: usize| -> Vec<f64> {
        let told = &found["parts"]["all"][model]["told"];
        assert_eq!(told["windows_broken"], 0);
        let by_group = told["errors"]["rmse_mg_dl"].as_array().expect("three groups");
        by_group.iter().map(|error| error.as_f64().expect("windows in each group")).collect()
    };
    let own = errors(0);
    assert!(own.iter().all(|error| *error < 6.0), "{own:?}");
    if published.is_some() {
        for (own, theirs) in own.iter().zip(errors(1)) {
            assert!(*own < 0.5 * theirs, "{own} {theirs}");
        }
    }
}

#[test]
fn a_search_for_widths_that_is_killed_goes_on_to_the_same_end() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = |name: &str| folder.path().join(name);
    let (whole, ended) = (out("whole"), out("ended"));
    let arguments = |out| ["widths", "--explore", "2", "--exploit", "1", "--out", out];
    run(&arguments(text(&whole)));

    let mut search = start(&arguments(text(&ended)));
    let (checkpoint, began) = (out("ended.checkpoint"), Instant::now());
    while !checkpoint.exists() {
        assert!(began.elapsed() < Duration::from_secs(300), "no trial was written down");
        std::thread::sleep(Duration::from_millis(20));
    }
    search.kill().expect("it runs");
    search.wait().expect("it ends");
    assert!(!ended.exists(), "an output is complete or absent");
    run(&arguments(text(&ended)));
    let read = |folder: &Path| fs::read(folder.join("widths.json")).expect("written");
    assert!(read(&whole) == read(&ended), "another end");
    assert!(!checkpoint.exists());
    assert_eq!(crate::outputs::checked(&whole), 2, "trials, manifest");
    let found = json(&whole.join("widths.json"));
    assert_eq!(found["trials"].as_array().map(Vec::len), Some(3));
}

#[test]
fn a_twin_is_bracketed_over_the_box_of_its_person() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = |name: &str| folder.path().join(name);
    let cohort = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/embedded/cohort");
    let (model, made) = (shipped(), out("twins"));
    let of_model = ["--model", text(&model), "--cohort", text(&cohort)];
    let quick = ["--variants", "--epochs", "2", "--out", text(&made)];
    run(&[&["twin"], of_model.as_slice(), &quick].concat());
    assert_eq!(
        crate::outputs::checked(&made),
        4,
        "data in use, twins, errors of free runs, manifest"
    );
    let twin = made.join("twins/P02.safetensors");
    let of_twin = [&["verify"], of_model.as_slice(), &["--twin", text(&twin)]].concat();
    let found = out("found");
    run(&[of_twin.as_slice(), &["--limit", "1", "--out", text(&found)]].concat());
    let rows = json(&found.join("conformance.json"))["rows"].as_array().expect("rows").clone();
    assert_eq!(rows.len(), 9, "residual, population and twin by X1, X3 and Q1");
    for row in &rows {
        let number = |key: &str| row[key].as_f64().expect("a number");
        assert!(number("m_lower") <= number("m_upper"), "{row:#}");
        let verdict = match (number("m_upper") <= 0.0, number("m_lower") > 0.0) {
            (true, _) => "proved",
            (_, true) => "violated",
            _ => "undecided",
        };
        assert_eq!(row["verdict"], verdict, "{row:#}");
    }
    // Weights that keep signs are a proof, whatever boxes leave open.
    let kept = made.join("variants/constrained_twin/P02.safetensors");
    let of_kept = [&["verify"], of_model.as_slice(), &["--twin", text(&kept)]].concat();
    run(&[of_kept.as_slice(), &["--limit", "1", "--out", text(&found)]].concat());
    let rows = json(&found.join("conformance.json"))["rows"].as_array().expect("rows").clone();
    let residual = rows.iter().filter(|row| row["network"] == "residual");
    assert_eq!(residual.filter(|row| row["verdict"] == "proved").count(), 3, "{rows:#?}");
    // A twin is proved where both of its networks are, and what proves the population's is on file.
    let file = json(&found.join("certificates.json"));
    let certified = file["certificates"].as_array().expect("certificates");
    assert!(!certified.is_empty(), "nothing of the population's network was certified");
    for parts in rows.chunks(3) {
        let names: Vec<_> = parts.iter().map(|row| row["network"].as_str()).collect();
        assert_eq!(names, [Some("residual"), Some("Q1"), Some("twin")]);
        let input = &parts[0]["input"];
        assert!(parts.iter().all(|row| row["input"] == *input && row["person_id"] == "P02"));
        assert_eq!(parts[0]["grounds"], "construction");
        let is_certified = certified.iter().any(|certificate| certificate["input"] == *input);
        assert_eq!(parts[1]["grounds"] == "certificate", is_certified, "{input}");
        assert_eq!(parts[2]["grounds"] == "summands", is_certified, "{input}");
    }
    assert_eq!(crate::outputs::checked(&found), 4, "rows, certificates, region, manifest");
    // A twin that does not keep them is not judged as one that does.
    std::fs::copy(&twin, &kept).expect("writable");
    let asked = ["evaluate", "--cohort", text(&cohort), "--twins", text(&made)];
    let judged = out("judged");
    let status = start(&[asked.as_slice(), &["--out", text(&judged)]].concat()).wait();
    assert_eq!(status.expect("it ends").code(), Some(1));
    assert!(!judged.exists());
    // A record without the twin's person, and a repair of a twin.
    let other = out("other");
    run(&["worlds", "--count", "1", "--people", "1", "--days", "2", "--out", text(&other)]);
    assert_eq!(crate::outputs::checked(&other), 3, "labels, label, manifest");
    let stranger = other.join("001/cohort");
    assert!(stranger.join("people.csv").exists(), "a world's cohort");
    let asked = ["verify", "--model", text(&model), "--twin", text(&twin)];
    let status = start(&[asked.as_slice(), &["--cohort", text(&stranger)]].concat())
        .wait()
        .expect("it ends");
    assert_eq!(status.code(), Some(1));
    let status = start(&[of_twin.as_slice(), &["--repair"]].concat()).wait().expect("it ends");
    assert_eq!(status.code(), Some(2), "wrong usage");
}
