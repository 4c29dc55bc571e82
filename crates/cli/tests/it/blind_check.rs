//! The blind check from the command line: each diagnosis in a process of its own.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::outputs;
use contract::blind_check::{BlindCheck, Label, OpenedLabel, Seal};

/// Two worlds from a seed that draws small ones: five people and three, a week each.
fn check(out: &Path, arguments: &[&str]) -> BlindCheck {
    let output = Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
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
    blind::seal::verify(&seal, &labels).expect("the labels that were sealed");
    for name in ["answers/world_0001.json", "cohorts/world_0002/people.csv", "report.html"] {
        assert!(!read(name).is_empty(), "{name}");
    }

    assert!(outputs::checked(&one) >= 6);

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
    let mut running = Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
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

#[test]
fn worlds_that_cannot_be_are_refused_in_words() {
    let parent = tempfile::tempdir().expect("a folder");
    let out = parent.path().join("out");
    for (arguments, status, word) in [
        (&["blind-check", "--worlds", "0", "--nulls", "0"][..], 1, "0 worlds"),
        (&["blind-check", "--worlds", "20000"], 1, "20012 worlds"),
        (&["blind-check", "--together", "nowhere"], 1, "two or more"),
        (
            &["blind-check", "--together", "a", "--together", "b"],
            1,
            "'a' holds no labels under seal",
        ),
        (&["blind-check", "--together", "a", "--seed", "3"], 2, "--seed"),
        (&["worlds", "--effect", "dusk"], 1, "there is no effect 'dusk'"),
        (&["worlds", "--days", "0"], 1, "--days 0"),
        (&["worlds", "--shift", "-1"], 1, "--shift -1"),
        (&["worlds", "--shift=-1"], 1, "--shift -1"),
        (&["worlds", "--generator", "bergman"], 2, "hovorka, padova"),
        (&["worlds", "--mixture", "3", "--effect", "dawn"], 2, "--effect"),
        (&["worlds", "--nulls", "3"], 2, "--mixture"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
            .args(arguments)
            .arg("--out")
            .arg(&out)
            .output()
            .expect("the program starts");
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {message}");
        assert!(message.contains(word), "{arguments:?}: {message}");
        assert!(!out.exists(), "{arguments:?}");
    }
}

#[test]
fn worlds_lie_beside_their_labels() {
    let parent = tempfile::tempdir().expect("a folder");
    let out = parent.path().join("out");
    let output = Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
        .args([
            "worlds",
            "--effect",
            "dawn+illness",
            "--shift",
            "10",
            "--people",
            "3",
            "--days",
            "7",
        ])
        .args(["--generator", "padova", "--regime", "closed-loop", "--count", "2", "-q", "--out"])
        .arg(&out)
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for place in ["001", "002"] {
        let text = fs::read(out.join(place).join("label.json")).expect("a label");
        let label: Label = serde_json::from_slice(&text).expect("its layout");
        assert_eq!((label.generator.as_str(), label.regime.as_str()), ("padova", "aid"));
        let acting: Vec<(&str, bool)> =
            label.effects.iter().map(|e| (e.effect.as_str(), e.in_library)).collect();
        assert_eq!(acting, [("dawn", true), ("illness", false)]);
        let cohort = cohort::read_folder(&out.join(place).join("cohort")).expect("a cohort");
        assert_eq!(cohort.people.len(), 3);
        assert!(cohort.people.iter().all(|p| p.record.len() == 7 * 288));
    }
}
