//! Folders that are files, links, full, read-only, or hold what must not be lost.

use std::fs;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

use super::case::{Cases, repository, text};

pub(super) fn add(cases: &mut Cases) {
    let cohort = repository("fixtures/embedded/cohort");
    let model = repository("crates/nn-statespace/model/population.safetensors");
    let stages: [&[&str]; 6] = [
        &["export", "--cohort", &cohort, "--to", "iglu"],
        &["diagnose", "--cohort", &cohort],
        &["train"],
        &["worlds", "--people", "1", "--days", "2"],
        &["verify", "--model", &model],
        &["reconcile", "--cohort", &cohort],
    ];
    for stage in stages {
        let name = stage[0];
        let mut out = |fault: &str, out: &str, words: &[&str]| {
            let typed = [stage, &["--out", out]].concat();
            cases.refused_as_it_is(&format!("{name}: --out {fault}"), &typed, words);
        };
        out("is a device", "/dev/null", &["/dev/null"]);
        out("is in a file", "/etc/hostname/out", &["/etc/hostname"]);
        out("has a name too long", &format!("/tmp/{}", "x".repeat(300)), &["xxx"]);
        let file = cases.file("file", "mine");
        out_is(cases, stage, "is a file", &file, &["is a file"]);
        let theirs = cases.file("thesis.txt", "years of work");
        let folder = text(Path::new(&theirs).parent().expect("a folder"));
        out_is(cases, stage, "holds somebody's file", &folder, &["thesis.txt", "did not write"]);
        let link = cases.place("link");
        symlink("nowhere", &link).expect("a link");
        out_is(cases, stage, "is a link to nothing", &text(&link), &["link", "nowhere"]);
    }
    cases.usage("an empty --seed", &["train", "--seed", ""], &["--seed"]);
    within_inputs(cases, &cohort);
    closed(cases, &cohort);
    unwritable(cases, &cohort);
    sources(cases, &cohort, &model);
}

fn out_is(cases: &mut Cases, stage: &[&str], fault: &str, out: &str, words: &[&str]) {
    let typed = [stage, &["--out", out]].concat();
    cases.refused_as_it_is(&format!("{}: --out {fault}", stage[0]), &typed, words);
}

/// Outputs that would lie among the inputs.
fn within_inputs(cases: &mut Cases, cohort: &str) {
    for stage in ["export", "reconcile", "diagnose"] {
        let copy = copy(cases, cohort);
        let mut typed = vec![stage, "--cohort"];
        let (folder, within) = (text(&copy), text(&copy.join("deep/out")));
        typed.push(&folder);
        if stage == "export" {
            typed.extend(["--to", "iglu"]);
        }
        let same = [&typed[..], &["--out", &folder]].concat();
        cases.refused_as_it_is(&format!("{stage}: --out is the input"), &same, &["input"]);
        let inside = [&typed[..], &["--out", &within]].concat();
        cases.refused_as_it_is(&format!("{stage}: --out is in the input"), &inside, &["input"]);
        let link = cases.place("link");
        symlink(&copy, &link).expect("a link");
        let linked = text(&link);
        let linked = [&typed[..], &["--out", &linked]].concat();
        cases.refused_as_it_is(&format!("{stage}: --out links to the input"), &linked, &["input"]);
    }
}

/// A copy of a cohort that anybody can read.
fn copy(cases: &Cases, cohort: &str) -> PathBuf {
    let copy = cases.place("cohort");
    fs::create_dir(&copy).expect("writable");
    for file in ["people.csv", "records.parquet"] {
        fs::copy(Path::new(cohort).join(file), copy.join(file)).expect("copied");
    }
    copy
}

/// Places that an ordinary user cannot write to or read.
fn closed(cases: &mut Cases, cohort: &str) {
    let mode = |path: &Path, mode| {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("ours");
    };
    let readable = text(&copy(cases, cohort));
    let closed = cases.place("closed");
    fs::create_dir(&closed).expect("writable");
    mode(&closed, 0o555);
    let typed = ["export", "--cohort", &readable, "--to", "iglu"];
    let out = text(&closed.join("out"));
    let within = [&typed[..], &["--out", &out]].concat();
    let words = ["cannot write", "closed"];
    cases.refused_for_a_user("export: --out is read-only", &within, &words, false);
    let secret = copy(cases, cohort);
    mode(&secret.join("people.csv"), 0o000);
    let typed = ["reconcile", "--cohort", &text(&secret)];
    let words = ["people.csv", "denied"];
    cases.refused_for_a_user("reconcile: a file that cannot be read", &typed, &words, true);
    let secret = copy(cases, cohort);
    mode(&secret, 0o000);
    let typed = ["diagnose", "--cohort", &text(&secret)];
    let words = ["cohort", "denied"];
    cases.refused_for_a_user("diagnose: a folder that cannot be read", &typed, &words, true);
}

/// Places that take no files: those of the system, and a full disk (where one can be made).
fn unwritable(cases: &mut Cases, cohort: &str) {
    let typed = ["export", "--cohort", cohort, "--to", "iglu"];
    for system in ["/proc/out", "/sys/out"] {
        let typed = [&typed[..], &["--out", system]].concat();
        cases.refused_as_it_is("export: --out is of the system", &typed, &["cannot write"]);
    }
    for stage in [
        &typed[..],
        &["worlds", "--people", "1", "--days", "20"],
        &["reconcile", "--cohort", cohort],
    ] {
        let small = cases.place("small");
        fs::create_dir(&small).expect("writable");
        let folder = text(&small);
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", "size=16k", "tmpfs", &folder])
            .output()
            .is_ok_and(|output| output.status.success());
        if !mounted {
            said("a full disk: a small one cannot be mounted here");
            return;
        }
        cases.mounted.push(small.clone());
        let out = text(&small.join("out"));
        let typed = [stage, &["--out", &out]].concat();
        cases.refused_as_it_is(
            &format!("{}: the disk is full", stage[0]),
            &typed,
            &["cannot", "No space left"],
        );
    }
}

/// Inputs that are no files.
fn sources(cases: &mut Cases, cohort: &str, model: &str) {
    let people = format!("{cohort}/people.csv");
    for stage in [
        &["diagnose", "--cohort"][..],
        &["reconcile", "--cohort"],
        &["export", "--to", "metabonet", "--cohort"],
        &["replay", "--model", model, "--cohort"],
        &["twin", "--model", model, "--cohort"],
        &["baselines", "--model", model, "--cohort"],
        &["effect-twins", "--model", model, "--cohort"],
        &["realism", "--cohort"],
        &["evidence", "--cohort"],
        &["blind-check", "--planted"],
        &["pipeline", "--cohort"],
    ] {
        let file = [stage, &[&people]].concat();
        cases.refused(&format!("{}: a file for a cohort", stage[0]), &file, &["people.csv"]);
        let nowhere = [stage, &["nowhere"]].concat();
        cases.refused(&format!("{}: no cohort", stage[0]), &nowhere, &["nowhere"]);
    }
    cases.refused_as_it_is("cohort check: absent", &["cohort", "check", "nowhere"], &["nowhere"]);
    cases.refused_as_it_is("cohort check: a file", &["cohort", "check", &people], &["people.csv"]);
    cases.refused_as_it_is("cohort new: a file", &["cohort", "new", &people], &["people.csv"]);
    cases.refused_as_it_is(
        "cohort new: a cohort",
        &["cohort", "new", cohort],
        &["there are files"],
    );
    let pipeline = ["pipeline", "--cohort", cohort];
    let absent = [&pipeline[..], &["--model", model, "--patients", "nowhere.csv"]].concat();
    cases.refused("pipeline: no patients", &absent, &["nowhere.csv"]);
    let garbage = cases.file("patients.csv", "a,b\n1,2\n");
    let typed = [&pipeline[..], &["--model", model, "--patients", &garbage]].concat();
    cases.refused(
        "pipeline: a table that holds no patients",
        &typed,
        &["patients.csv", "no column"],
    );
    let typed = ["baselines", "--cohort", cohort, "--model", model, "--patients", &garbage];
    cases.refused(
        "baselines: a table that holds no patients",
        &typed,
        &["patients.csv", "no column"],
    );
}

fn said(skipped: &str) {
    #[expect(clippy::print_stderr, reason = "a skipped case must say that it was skipped")]
    {
        eprintln!("skipped: {skipped}");
    }
}
