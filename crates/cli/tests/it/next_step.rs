//! Every command that writes something ends with one line of what to look at next.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Commands that write nothing.
const SILENT: [&str; 1] = ["completions"];
/// Commands of which a run takes minutes or other people's files. What they write goes through the same
/// folder of the crate `pipeline`, which remembers it.
const LONG: [&str; 9] = [
    "baselines",
    "bench",
    "blind-check",
    "effect-twins",
    "import-model",
    "pipeline",
    "realism",
    "train-posterior",
    "widths",
];

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_t1d-twins")).args(arguments).output().expect("it starts")
}

fn text(path: &Path) -> &str {
    path.to_str().expect("temporary paths are UTF-8")
}

fn repository(path: &str) -> String {
    text(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)).to_owned()
}

/// The names of all commands.
fn commands() -> Vec<String> {
    let help = String::from_utf8(run(&["--help"]).stdout).expect("UTF-8");
    help.lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| line.starts_with("  "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|command| *command != "help")
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_command_that_writes_ends_with_what_comes_next() {
    let parent = tempfile::tempdir().expect("a folder");
    let at = |name: &str| -> PathBuf { parent.path().join(name) };
    let path = |name: &str| text(&at(name)).to_owned();
    let embedded = repository("fixtures/embedded/cohort");
    let model = repository("crates/nn-statespace/model/population.safetensors");
    let (patients, meals) =
        (repository("fixtures/golden/patients.csv"), repository("fixtures/golden/meals.csv"));
    let nightscout = repository("fixtures/import/nightscout");
    let (verified, twins) = (path("verify"), path("twin"));
    /// Options, and the beginning of the last line, in which OUT is the output folder.
    type Case<'a> = (&'a [&'a str], &'a str);
    let cases: &[Case<'_>] = &[
        (
            &["cohort", "new"],
            "next: fill in OUT/people.csv and OUT/records.csv, then t1d-twins cohort check",
        ),
        (&["cohort", "check", &embedded], "next: t1d-twins diagnose --cohort "),
        (&["import", "--from", "nightscout", &nightscout], "next: t1d-twins diagnose --cohort OUT"),
        (&["export", "--cohort", &embedded, "--to", "iglu"], "next: read the files in OUT"),
        (
            &["simulate", "--patients", &patients, "--meals", &meals, "--days", "1"],
            "next: plot the columns of OUT/traces.csv",
        ),
        (&["development-set"], "next: look at OUT/weeks.csv"),
        (&["train"], "next: t1d-twins verify --model OUT/population.safetensors"),
        (&["verify", "--model", &model], "next: t1d-twins report OUT"),
        (
            &["twin", "--cohort", &embedded, "--model", &model, "--epochs", "1"],
            "next: t1d-twins evaluate --cohort COHORT --twins OUT",
        ),
        (
            &["replay", "--cohort", &embedded, "--model", &model],
            "next: plot the columns of OUT/traces.csv",
        ),
        (&["evaluate", "--cohort", &embedded, "--twins", &twins], "next: t1d-twins report OUT"),
        (&["diagnose", "--cohort", &embedded], "next: open OUT/report.html in a browser"),
        (&["reconcile", "--cohort", &embedded], "next: t1d-twins diagnose --cohort OUT"),
        (&["evidence", "--cohort", &embedded], "next: t1d-twins train-posterior --table OUT"),
        (
            &["worlds", "--people", "1", "--days", "4"],
            "next: t1d-twins diagnose --cohort OUT/001/cohort",
        ),
        (&["report", &verified], "next: open "),
        (&["steady-state", "--model", &model], "next: look at OUT/steady_state.json"),
        (&["held-out", "--model", &model], "next: look at OUT/"),
        (&["trajectories", "--model", &model], "next: look at OUT/trajectories.json"),
    ];
    for (typed, expected) in cases {
        let out = path(typed[0]);
        // These take a folder in the place of --out.
        let arguments = match **typed {
            ["cohort", "new"] => [typed, &[out.as_str()][..]].concat(),
            ["cohort", ..] | ["report", ..] => typed.to_vec(),
            _ => [typed, &["--out", out.as_str()][..]].concat(),
        };
        let done = run(&arguments);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(done.status.success(), "{arguments:?}: {said}");
        let last = said.lines().last().unwrap_or_default();
        let expected = expected.replace("OUT", &out).replace("COHORT", &embedded);
        assert!(last.starts_with(&expected), "{arguments:?}: '{last}' is not '{expected}'");
        assert_eq!(said.matches("next: ").count(), 1, "{arguments:?}: {said}");
        // On the standard output the result stands alone.
        assert!(!String::from_utf8_lossy(&done.stdout).contains("next: "), "{arguments:?}");
    }

    let missing: Vec<String> = commands()
        .into_iter()
        .filter(|command| {
            let named = |list: &[&str]| list.contains(&command.as_str());
            !named(&SILENT) && !named(&LONG) && cases.iter().all(|(typed, _)| typed[0] != command)
        })
        .collect();
    assert!(missing.is_empty(), "commands whose last line is not tested: {missing:?}");
}

#[test]
fn nothing_is_said_with_q_and_after_a_refusal() {
    let parent = tempfile::tempdir().expect("a folder");
    let out = parent.path().join("out");
    let model = repository("crates/nn-statespace/model/population.safetensors");
    let quiet = run(&["steady-state", "--model", &model, "--out", text(&out), "-q"]);
    assert!(quiet.status.success());
    assert_eq!(String::from_utf8_lossy(&quiet.stderr), "");
    for arguments in
        [&["completions", "bash"][..], &["steady-state", "--model", "nowhere", "--out", text(&out)]]
    {
        let said = String::from_utf8_lossy(&run(arguments).stderr).into_owned();
        assert!(!said.contains("next: "), "{arguments:?}: {said}");
    }
}
