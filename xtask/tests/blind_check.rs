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

/// Names of what lies in a folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_check_leaves_nothing_and_no_process() {
    let parent = tempfile::tempdir().expect("a folder");
    let temporary = parent.path().join("temporary");
    fs::create_dir(&temporary).expect("writable");
    let mut running = Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(["blind-check", "--worlds", "0", "--nulls", "9", "--seed", "18", "-q", "--out"])
        .arg(parent.path().join("out"))
        .env("TMPDIR", &temporary)
        .spawn()
        .expect("the program starts");
    // A folder under the temporary one: a diagnosis is being asked.
    while names(&temporary).is_empty() {
        assert!(running.try_wait().expect("ours").is_none(), "over before a diagnosis was seen");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let interrupt = Command::new("kill").args(["-INT", &running.id().to_string()]).status();
    assert!(interrupt.expect("kill").success());
    assert_eq!(running.wait().expect("ours").code(), Some(130));
    assert_eq!(names(parent.path()), ["temporary"]);
    // A diagnosis that went on would write its answer within a second.
    std::thread::sleep(std::time::Duration::from_secs(1));
    assert!(names(&temporary).is_empty(), "{:?}", names(&temporary));
}
