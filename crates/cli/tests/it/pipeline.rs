//! The README's first command, end to end. Takes minutes: runs where `T1D_SLOW` is set.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::outputs;

const SWITCH: &str = "T1D_SLOW";

fn pipeline(out: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
        .args(["pipeline", "--out", out.to_str().expect("UTF-8")])
        .args(more)
        .output()
        .expect("the program starts")
}

#[test]
fn the_embedded_cohort_ends_in_a_report_and_a_second_run_keeps_every_stage() {
    if std::env::var_os(SWITCH).is_none() {
        #[expect(clippy::print_stderr, reason = "a skipped test must say that it was skipped")]
        {
            eprintln!("skipped: the whole pipeline takes minutes; set {SWITCH}=1 to run it");
        }
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("pipeline");
    let output = pipeline(&out, &[]);
    let notes = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{notes}");
    let html = fs::read_to_string(out.join("report.html")).expect("a report");
    for words in [
        "Where the gap lies",
        "Example days",
        "Physiological conformance",
        "Not a medical device",
        "TIR",
    ] {
        assert!(html.contains(words), "{words}");
    }
    assert!(!html.contains("NaN"));
    let files = outputs::checked(&out);
    assert!(files > 20, "{files} files");
    let tables = fs::read_to_string(out.join("tables.txt")).expect("the tables");
    for words in [
        "Table 'best_archs'",
        "Outcomes of ",
        "Largest z of each network",
        "Beside the paper's appendix",
        "Table 'overall_glucoseOutcomes'",
        "Table 'inputsContributions'",
        "Forecast RMSE",
        "What-if order",
    ] {
        assert!(tables.contains(words), "{words}");
    }
    assert!(!tables.contains("was not made"), "{tables}");

    let model = out.join("2-train/population.safetensors");
    let before = fs::read(&model).expect("a model");
    let output = pipeline(&out, &[]);
    let notes = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{notes}");
    assert_eq!(notes.matches("done before, kept").count(), 8, "{notes}");
    assert_eq!(fs::read(&model).expect("a model"), before);

    // The same seed gives the same bytes, on another number of threads too.
    let again = folder.path().join("again");
    let output = pipeline(&again, &["--threads", "1", "-q"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for file in
        ["2-train/population.safetensors", "7-evaluate/outcomes.json", "8-diagnose/diagnosis.json"]
    {
        assert_eq!(
            fs::read(out.join(file)).expect("first run"),
            fs::read(again.join(file)).expect("second run"),
            "{file}"
        );
    }
}
