//! Damaged weight files, given to every command that reads a model.

use std::fs::{self, File};

use super::case::{Cases, repository};

/// What the message about a population model must say.
const NO_MODEL: &str = "population model";

pub(super) fn add(cases: &mut Cases) {
    let good = fs::read(repository("crates/nn-statespace/model/population.safetensors"))
        .expect("the shipped model");
    let header = 8 + usize::try_from(u64::from_le_bytes(good[..8].try_into().expect("8 bytes")))
        .expect("a short header");
    let length = |length: u64| [&length.to_le_bytes()[..], &good[8..]].concat();
    let header_text = |from: &str, to: &str| {
        let text = String::from_utf8(good[8..header].to_vec()).expect("JSON");
        assert!(text.contains(from), "{from} is not in the header");
        let text = text.replacen(from, to, 1);
        [&(text.len() as u64).to_le_bytes()[..], text.as_bytes(), &good[header..]].concat()
    };
    let weight = |value: f64| {
        let mut bytes = good.clone();
        let last = bytes.len() - 8;
        bytes[last..].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    let deep = format!("{{\"__metadata__\":{}{}}}", "[".repeat(50_000), "]".repeat(50_000));
    let deep = [&(deep.len() as u64).to_le_bytes()[..], deep.as_bytes()].concat();
    let damaged: Vec<(&str, Vec<u8>, &[&str])> = vec![
        ("empty", Vec::new(), &[NO_MODEL]),
        ("text", b"not a model".to_vec(), &[NO_MODEL]),
        ("garbage", (0..9000_u32).map(|i| ((i * i) >> 3) as u8).collect(), &[NO_MODEL]),
        ("only a length", good[..8].to_vec(), &[NO_MODEL]),
        ("cut in its header", good[..header / 2].to_vec(), &[NO_MODEL]),
        ("cut in its weights", good[..good.len() - 100].to_vec(), &[NO_MODEL]),
        ("header of 2^64 bytes", length(u64::MAX), &[NO_MODEL]),
        ("header of 2^40 bytes", length(1 << 40), &[NO_MODEL]),
        ("header longer than the file", length(90_000_000), &[NO_MODEL]),
        ("header is no JSON", length(5), &[NO_MODEL]),
        ("deep header", deep, &[NO_MODEL]),
        ("NaN weight", weight(f64::NAN), &[NO_MODEL, "not a finite number"]),
        ("infinite weight", weight(f64::INFINITY), &[NO_MODEL, "not a finite number"]),
        ("other kind of weights", header_text("\"population\"", "\"populatiom\""), &[NO_MODEL]),
        ("other version", header_text("population/1", "population/9"), &[NO_MODEL, "population/9"]),
        (
            "tensor missing",
            header_text("Q1.hidden.weight", "Q9.hidden.weight"),
            &[NO_MODEL, "Q1.hidden.weight"],
        ),
        ("wrong type of weights", header_text("F64", "I64"), &[NO_MODEL, "64-bit"]),
        ("unknown signal", header_text("u_insulin", "u_insulan"), &[NO_MODEL, "u_insulan"]),
        ("more after the end", [&good[..], &[0; 8]].concat(), &[NO_MODEL]),
    ];
    for (turn, (name, bytes, words)) in damaged.into_iter().enumerate() {
        let file = cases.file("population.safetensors", bytes);
        commands(cases, turn, &format!("model: {name}"), &file, words);
    }
    let cohort = repository("fixtures/embedded/cohort");
    let nowhere = cases.place("nowhere.safetensors").to_string_lossy().into_owned();
    for turn in 0..10 {
        commands(cases, turn, "model: absent", &nowhere, &["nowhere.safetensors"]);
    }
    for turn in 0..9 {
        commands(cases, turn, "model: a folder", &cohort, &["folder"]);
    }
    for turn in [0, 2, 4, 6, 7] {
        commands(cases, turn, "model: without an end", "/dev/zero", &["/dev/zero"]);
    }
    let vast = cases.place("vast.safetensors");
    File::create(&vast).and_then(|file| file.set_len(64 << 30)).expect("a file of holes");
    let vast = vast.to_string_lossy().into_owned();
    for turn in [1, 3, 5] {
        commands(cases, turn, "model: 64 GiB", &vast, &["vast.safetensors", "GiB"]);
    }
    let text = cases.file("network.safetensors", "not a model");
    for (name, model, words) in [
        ("blind check: no model", text.as_str(), &["neither a population model nor a twin"][..]),
        ("blind check: a cohort for a model", &cohort, &["no twins"]),
        ("blind check: no file for a model", &nowhere, &["nowhere.safetensors"]),
    ] {
        cases.refused(name, &["blind-check", "--worlds", "1", "--model", model], words);
    }
    twins(cases, &cohort);
    published(cases);
}

/// The command of this turn on a model.
fn commands(cases: &mut Cases, turn: usize, name: &str, model: &str, words: &[&str]) {
    let cohort = repository("fixtures/embedded/cohort");
    let region = repository("crates/nn-statespace/model/region.json");
    let all: [&[&str]; 10] = [
        &["verify", "--model", model],
        &["twin", "--cohort", &cohort, "--model", model],
        &["baselines", "--cohort", &cohort, "--model", model],
        &["replay", "--cohort", &cohort, "--model", model],
        &["diagnose", "--cohort", &cohort, "--model", model],
        &["steady-state", "--model", model],
        &["trajectories", "--model", model],
        &["held-out", "--model", model],
        &["effect-twins", "--cohort", &cohort, "--model", model],
        &["pipeline", "--cohort", &cohort, "--model", model],
    ];
    let mut arguments = all[turn % all.len()].to_vec();
    if arguments[0] == "verify" && turn > 0 {
        arguments.extend(["--region", &region]);
    }
    cases.refused(name, &arguments, words);
}

/// What is no twin.
fn twins(cases: &mut Cases, cohort: &str) {
    let model = repository("crates/nn-statespace/model/population.safetensors");
    let replay = ["replay", "--cohort", cohort, "--model", &model, "--twin"];
    let text = cases.file("twin.safetensors", "not a twin");
    for (name, twin, words) in [
        ("twin: text", text.as_str(), &["not a twin"][..]),
        ("twin: a population model", &model, &["not a twin", "no twin in this file"]),
        ("twin: a folder", cohort, &["folder"]),
        ("twin: absent", "nowhere.safetensors", &["nowhere.safetensors"]),
        ("twin: without an end", "/dev/zero", &["/dev/zero"]),
    ] {
        cases.refused(name, &[&replay[..], &[twin]].concat(), words);
        let verify = ["verify", "--model", &model, "--cohort", cohort, "--twin", twin];
        cases.refused(name, &verify, words);
        cases.refused(name, &["trajectories", "--model", &model, "--twin", twin], words);
    }
    cases.refused(
        "twins: no folder of twins",
        &["diagnose", "--cohort", cohort, "--model", cohort],
        &["no twins"],
    );
    cases.refused(
        "twins: to continue from",
        &["twin", "--cohort", cohort, "--model", &model, "--continue-from", cohort],
        &["no twins", "twins"],
    );
    let initial = cases.file("table.csv", "a,b\n1,2\n");
    let start = format!("table:{initial}");
    cases.refused(
        "initial states: another table",
        &["replay", "--cohort", cohort, "--model", &model, "--initial", &start],
        &["table.csv"],
    );
    cases.refused(
        "initial states: absent",
        &["replay", "--cohort", cohort, "--model", &model, "--initial", "table:none.csv"],
        &["none.csv"],
    );
    cases.refused(
        "initial states: compared with another table",
        &["steady-state", "--model", &model, "--compare", &initial],
        &["table.csv"],
    );
}

/// Folders that are no published model.
fn published(cases: &mut Cases) {
    let file = cases.file("population_model_05022024_epoch_15.pt", "PK garbage");
    let folder = std::path::Path::new(&file).parent().expect("a folder").to_string_lossy();
    let folder = folder.into_owned();
    let import = |from: &'static str, folder: &str| {
        ["import-model", "--from", from, folder].map(str::to_owned)
    };
    for (name, folder, words) in [
        ("published model: garbage", folder.as_str(), &["scaler_states.pkl"][..]),
        ("published model: a file", &file, &["folder"]),
        ("published model: absent", "nowhere", &["nowhere"]),
    ] {
        let typed = import("t1dsim", folder);
        let typed: Vec<&str> = typed.iter().map(String::as_str).collect();
        cases.refused(name, &typed, words);
    }
}
