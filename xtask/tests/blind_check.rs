//! The blind check from the command line: each diagnosis in a process of its own.

use std::fs;
use std::path::Path;
use std::process::Command;

use blind::{BlindCheck, OpenedLabel, Seal};

/// Two worlds from a seed that draws small ones: five people and three, a week each.
fn check(out: &Path, arguments: &[&str]) -> BlindCheck {
    let output = Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(["blind-check", "--worlds", "1", "--nulls", "1", "--seed", "18", "-q", "--out"])
        .arg(out)
        .args(arguments)
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read(out.join("blind_check.json")).expect("a score");
    serde_json::from_slice(&text).expect("the layout of blind_check.json")
}

#[test]
fn a_small_check_is_sealed_answered_opened_and_the_same_again() {
    let parent = tempfile::tempdir().expect("a folder");
    let (one, again) = (parent.path().join("one"), parent.path().join("again"));
    let mut first = check(&one, &[]);
    let mut second = check(&again, &["--threads", "1"]);

    assert_eq!((first.failed.count, first.failed.of), (0, 2), "{:?}", first.worlds);
    assert_eq!(first.false_alarms.of, 1);
    let read = |name: &str| fs::read(one.join(name)).expect(name);
    let seal: Seal = serde_json::from_slice(&read("seal.json")).expect("a seal");
    let labels: Vec<OpenedLabel> = serde_json::from_slice(&read("labels.json")).expect("labels");
    seal.verify(&labels).expect("the labels that were sealed");
    for name in ["answers/world_0001.json", "cohorts/world_0002/people.csv", "report.html"] {
        assert!(!read(name).is_empty(), "{name}");
    }

    // Times differ; nothing else does.
    for row in first.worlds.iter_mut().chain(&mut second.worlds) {
        row.seconds = 0.0;
    }
    assert_eq!(first, second);
    let left = fs::read_dir(parent.path()).expect("a folder").count();
    assert_eq!(left, 2, "something was left behind");
}
