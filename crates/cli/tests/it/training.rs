//! `train` ended by force, and the same command given again.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn train(out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_t1d-twins"));
    command.args(["train", "--seed", "4", "--out"]).arg(out).stdout(Stdio::null());
    command
}

/// The model's bytes and the curves of a finished run.
fn result(out: &Path) -> (Vec<u8>, serde_json::Value) {
    let model = fs::read(out.join("population.safetensors")).expect("a model");
    let report = fs::read(out.join("training.json")).expect("a report");
    let mut report: serde_json::Value = serde_json::from_slice(&report).expect("JSON");
    report.as_object_mut().expect("an object").remove("seconds");
    (model, report)
}

#[test]
fn a_run_that_is_killed_goes_on_to_the_same_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (whole, ended) = (folder.path().join("whole"), folder.path().join("ended"));
    let output = train(&whole).output().expect("starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));

    let checkpoint = folder.path().join("ended.checkpoint");
    let mut child = train(&ended).stderr(Stdio::null()).spawn().expect("starts");
    let begun = Instant::now();
    while !checkpoint.exists() {
        assert!(begun.elapsed() < Duration::from_secs(300), "no checkpoint");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().expect("runs still");
    assert!(!child.wait().expect("ended").success(), "the run ended by itself");
    assert!(!ended.exists(), "an output folder is complete or absent");

    let output = train(&ended).output().expect("starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.contains("goes on from"), "{said}");
    assert!(result(&ended) == result(&whole), "the resumed run gave other files");
    assert!(!checkpoint.exists(), "a finished run needs no checkpoint");
}
