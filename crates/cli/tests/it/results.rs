//! What stands on the standard output: tables, JSON and completions; and files for other programs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use cohort::{Channel, Cohort, ImportFormat, import, read_folder};

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_t1d-twins")).args(arguments).output().expect("it starts")
}

fn text(path: &Path) -> &str {
    path.to_str().expect("temporary paths are UTF-8")
}

fn repository(path: &str) -> String {
    text(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)).to_owned()
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn tables_go_to_the_standard_output_and_json_takes_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let model = repository("crates/nn-statespace/model/population.safetensors");
    let steady = ["steady-state", "--model", &model, "--out", text(&out)];
    let tables = run(&[&steady[..], &["-q"]].concat());
    assert!(tables.status.success(), "{}", said(&tables.stderr));
    assert!(said(&tables.stdout).lines().count() > 3, "{}", said(&tables.stdout));
    assert_eq!(said(&tables.stderr), "");

    let json = run(&[&steady[..], &["--json"]].concat());
    let found: serde_json::Value = serde_json::from_slice(&json.stdout).expect("JSON alone");
    let written = fs::read(out.join("steady_state.json")).expect("written");
    let written: serde_json::Value = serde_json::from_slice(&written).expect("JSON");
    assert_eq!(found, written);

    let none = run(&["worlds", "--json", "--out", text(&folder.path().join("none"))]);
    assert_eq!(none.status.code(), Some(1));
    assert!(said(&none.stderr).contains("--json: the result of 'worlds' is no JSON"));
}

#[test]
fn shells_complete_every_command() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = run(&["completions", shell]);
        let script = said(&output.stdout);
        assert!(output.status.success(), "{shell}");
        for word in ["diagnose", "import-model", "training-days"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    assert_eq!(run(&["completions", "dos"]).status.code(), Some(2));
}

#[test]
fn completions_that_nobody_reads_are_no_fault() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
        .args(["completions", "bash"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("a child");
    assert!(output.status.success(), "{}", said(&output.stderr));
    assert_eq!(said(&output.stderr), "");
}

#[test]
fn a_twin_on_the_record_of_another_person_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let cohort = repository("fixtures/embedded/cohort");
    let model = repository("crates/nn-statespace/model/population.safetensors");
    let twins = at("twins");
    let typed = ["twin", "--cohort", &cohort, "--model", &model, "--epochs", "1", "-q"];
    let output = run(&[&typed[..], &["--out", text(&twins)]].concat());
    assert!(output.status.success(), "{}", said(&output.stderr));
    let mut files: Vec<PathBuf> = fs::read_dir(twins.join("twins"))
        .expect("twins")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    files.sort();
    let (twin, traces) = (text(&files[0]).to_owned(), at("traces"));
    let id = files[0].file_stem().expect("a name").to_string_lossy().into_owned();
    let typed = ["replay", "--cohort", &cohort, "--model", &model, "--twin", &twin];
    let output = run(&[&typed[..], &["--out", text(&traces)]].concat());
    let notes = said(&output.stderr);
    assert!(output.status.success(), "{notes}");
    let people = read_folder(Path::new(&cohort)).expect("a cohort").people;
    for person in &people {
        let warned = notes.contains(&format!(
            "this is the twin of '{id}', and the record is that of '{}'",
            person.id
        ));
        assert_eq!(warned, person.id != id, "{}: {notes}", person.id);
    }
}

#[test]
fn every_format_is_exported_and_what_can_be_read_back_is_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let source = repository("fixtures/embedded/cohort");
    let original = read_folder(Path::new(&source)).expect("a cohort");
    for (format, reader) in [
        ("iglu", None),
        ("replaybg", Some(ImportFormat::Replaybg)),
        ("simglucose", Some(ImportFormat::Simglucose)),
        ("metabonet", Some(ImportFormat::Metabonet)),
    ] {
        let out = folder.path().join(format);
        let typed = ["export", "--cohort", &source, "--to", format, "--out", text(&out)];
        let output = run(&typed);
        assert!(output.status.success(), "{format}: {}", said(&output.stderr));
        assert!(out.join("manifest.json").is_file(), "{format}");
        match reader {
            None => {
                let table = fs::read_to_string(out.join("iglu.csv")).expect("written");
                let mut lines = table.lines();
                assert_eq!(lines.next(), Some("id,time,gl"));
                assert_eq!(lines.count(), readings(&original).count());
            }
            Some(reader) => {
                let back = import(reader, &out).expect(format).cohort;
                assert_eq!(back.people.len(), original.people.len(), "{format}");
                same_readings(format, &original, &back);
                same_doses(format, &original, &back);
            }
        }
    }
    let wrong = run(&["export", "--cohort", &source, "--to", "excel"]);
    assert_eq!(wrong.status.code(), Some(2));
}

fn readings(cohort: &Cohort) -> impl Iterator<Item = f64> + '_ {
    cohort.people.iter().flat_map(|person| person.record.cgm().iter().flatten().copied())
}

fn same_readings(format: &str, original: &Cohort, back: &Cohort) {
    let (ours, theirs): (Vec<f64>, Vec<f64>) =
        (readings(original).collect(), readings(back).collect());
    assert_eq!(ours.len(), theirs.len(), "{format}");
    for (a, b) in ours.iter().zip(&theirs) {
        // Formats hold single precision or six digits.
        assert!((a - b).abs() < 1e-3, "{format}: {a} {b}");
    }
}

/// Insulin and carbohydrate of everybody in all; simglucose does not tell basal from bolus.
fn same_doses(format: &str, original: &Cohort, back: &Cohort) {
    let sum = |cohort: &Cohort, channel: Channel| -> f64 {
        cohort.people.iter().flat_map(|p| p.record.channel(channel).iter().flatten()).sum()
    };
    let insulin =
        |cohort: &Cohort| sum(cohort, Channel::Basal) / 12.0 + sum(cohort, Channel::Bolus);
    for (what, a, b) in [
        ("insulin", insulin(original), insulin(back)),
        ("carbohydrate", sum(original, Channel::Carbs), sum(back, Channel::Carbs)),
    ] {
        assert!((a - b).abs() < 1e-3 * a, "{format}: {what} {a} {b}");
    }
}

#[test]
fn a_zone_is_taken_where_the_source_holds_instants() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = |format: &str, zone: &[&str]| {
        let out = folder.path().join(format!("{format}{}", zone.len()));
        let source = repository(&format!("fixtures/import/{format}"));
        let typed = [&["import", "--from", format, &source, "--out", text(&out)], zone].concat();
        let output = run(&typed);
        assert!(output.status.success(), "{format}: {}", said(&output.stderr));
        (read_folder(&out).expect("a cohort").people[0].record.start(), said(&output.stderr))
    };
    for format in ["nightscout", "tidepool"] {
        let (stated, _) = first(format, &[]);
        let (given, notes) = first(format, &["--zone", "Pacific/Auckland"]);
        assert_ne!(stated, given, "{format}");
        assert!(notes.contains("--zone says it"), "{notes}");
        let out = folder.path().join("refused");
        let source = repository(&format!("fixtures/import/{format}"));
        for (option, value, words) in [
            ("--zone", "Moon/Sea", "no such zone"),
            ("--unit", "glucose=mmol/L", "needs none of --map"),
        ] {
            let typed = ["import", "--from", format, &source, option, value, "--out", text(&out)];
            let output = run(&typed);
            assert_eq!(output.status.code(), Some(1), "{format} {option}");
            assert!(said(&output.stderr).contains(words), "{}", said(&output.stderr));
        }
    }
    let typed = [
        "import",
        "--from",
        "ohio",
        &repository("fixtures/import/ohio"),
        "--zone",
        "Europe/Madrid",
    ];
    assert_eq!(run(&typed).status.code(), Some(1));
}
