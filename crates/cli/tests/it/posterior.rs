//! Tables that a posterior is trained on, and what is said of tables that it cannot be trained on.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use contract::blind_check::Label;

fn xtask(arguments: &[&str], out: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
        .args(arguments)
        .arg("--out")
        .arg(out)
        .arg("-q")
        .output()
        .expect("the program starts")
}

fn embedded() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/embedded/cohort")
}

#[test]
fn a_table_has_a_row_a_cohort_and_is_the_same_for_any_number_of_threads() {
    let parent = tempfile::tempdir().expect("a folder");
    let cohort = embedded();
    let cohort = cohort.to_str().expect("a path in UTF-8");
    let of = |threads: &str| {
        let out = parent.path().join(threads);
        let output = xtask(&["evidence", "--cohort", cohort, "--threads", threads], &out);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(crate::outputs::checked(&out), 3, "names, labels, manifest");
        ["statistics.safetensors", "names.json", "labels.json"]
            .map(|name| fs::read(out.join(name)).expect("written"))
    };
    let one = of("1");
    assert_eq!(one, of("2"));
    let names: Vec<String> = serde_json::from_slice(&one[1]).expect("names");
    let labels: Vec<Label> = serde_json::from_slice(&one[2]).expect("labels");
    assert_eq!((labels.len(), labels[0].people), (1, 6));
    for kind in ["units/meal/GutTime/z", "evidence/exercise", "cohort/people", "spread/egp/day"] {
        assert!(names.iter().any(|name| name == kind), "{kind}");
    }

    // Worlds of one hand tell nothing of another, and those of two leave none that sets a bar.
    let table = parent.path().join("1");
    let table = table.to_str().expect("a path in UTF-8");
    let refused = parent.path().join("posterior");
    let output = xtask(&["train-posterior", "--table", table], &refused);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("too few hands (1)"), "{message}");
    assert!(!refused.exists());
}

#[test]
fn what_is_no_table_is_refused_in_words() {
    let parent = tempfile::tempdir().expect("a folder");
    let empty = parent.path().join("empty");
    fs::create_dir(&empty).expect("writable");
    let folder = empty.to_str().expect("a path in UTF-8");
    let out = parent.path().join("out");
    let output = xtask(&["train-posterior", "--table", folder], &out);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("names.json") && message.contains(folder), "{message}");
    assert!(!out.exists());
}

#[test]
fn an_answer_is_the_same_for_any_number_of_threads_and_a_file_that_is_none_is_refused() {
    let parent = tempfile::tempdir().expect("a folder");
    let cohort = embedded();
    let cohort = cohort.to_str().expect("a path in UTF-8");
    let of = |threads: &str| {
        let out = parent.path().join(threads);
        let output = xtask(&["diagnose", "--cohort", cohort, "--threads", threads], &out);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        fs::read(out.join("diagnosis.json")).expect("written")
    };
    let one = of("1");
    assert_eq!(one, of("2"));
    let diagnosis: gap::Diagnosis = serde_json::from_slice(&one).expect("a diagnosis");
    let said = diagnosis.posterior;
    let none = diagnosis.candidates.iter().find(|candidate| candidate.effect == "none");
    let none = none.expect("an answer that nothing is missing").probability;
    assert!((said.something + none - 1.0).abs() < 1e-6, "{} and {none}", said.something);

    let file = parent.path().join("posterior");
    fs::write(&file, "nonsense").expect("writable");
    let file = file.to_str().expect("a path in UTF-8");
    let out = parent.path().join("refused");
    let output = xtask(&["diagnose", "--cohort", cohort, "--posterior", file], &out);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("the posterior cannot be read"), "{message}");
    assert!(!out.exists());
}
