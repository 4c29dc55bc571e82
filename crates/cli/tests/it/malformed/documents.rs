//! Damaged JSON files, regions, tables and folders that a command wrote and another reads.

use std::fs;
use std::path::Path;

use super::case::{Cases, repository, text};

/// The parts of a report and what one of their keys holds.
const PARTS: [&str; 10] = [
    "outcomes.json",
    "conformance.json",
    "diagnosis.json",
    "training.json",
    "twins.json",
    "import_report.json",
    "example_day.json",
    "what_if.json",
    "agp.json",
    "blind_check.json",
];

pub(super) fn add(cases: &mut Cases) {
    regions(cases);
    reports(cases);
    others(cases);
    tables_of_simulate(cases);
}

fn deep() -> String {
    format!("{{\"bounds\":{}{}}}", "[".repeat(100_000), "]".repeat(100_000))
}

fn regions(cases: &mut Cases) {
    let model = repository("crates/nn-statespace/model/population.safetensors");
    let good = fs::read_to_string(repository("crates/nn-statespace/model/region.json"))
        .expect("the shipped region");
    let edited = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        good.replacen(from, to, 1)
    };
    let first = "10.211593627929688";
    for (name, region, words) in [
        ("empty", String::new(), &["region.json"][..]),
        ("truncated", good[..good.len() / 2].to_owned(), &["region.json", "line"]),
        ("garbage", "\u{1}\u{2}\u{3}".to_owned(), &["region.json", "line 1"]),
        ("an array", "[1, 2]".to_owned(), &["region.json", "line 1"]),
        ("deep", deep(), &["region.json", "line 1"]),
        ("unknown key", edited("\"unit\"", "\"colour\": 1, \"unit\""), &["region.json", "colour"]),
        ("no unit", edited("\"unit\"", "\"units\""), &["region.json", "unit"]),
        ("unknown unit", edited("\"scaled\"", "\"miles\""), &["region.json", "miles"]),
        ("unknown signal", edited("\"C1\"", "\"C9\""), &["region", "C9"]),
        (
            "signal missing",
            edited("\"C1\": [\n      0.0,\n      10.211593627929688\n    ],", ""),
            &["region", "C1"],
        ),
        ("signal twice", edited("\"C1\"", "\"C2\""), &["region.json", "C2", "twice"]),
        ("text for a number", edited(first, "\"ten\""), &["region.json", "line"]),
        ("three numbers", edited(first, "1, 2"), &["region.json", "line"]),
        ("number too large", edited(first, "1e999"), &["region.json", "line"]),
        ("upside down", edited(first, "-5"), &["C1"]),
        ("infinitely wide", edited(first, "1e308"), &["C1"]),
    ] {
        let file = cases.file("region.json", region);
        let typed = ["verify", "--model", &model, "--region", &file, "--limit", "1"];
        cases.refused(&format!("region: {name}"), &typed, words);
    }
    let verify = ["verify", "--model", &model, "--region"];
    let folder = repository("docs");
    cases.refused("region: absent", &[&verify[..], &["none.json"]].concat(), &["none.json"]);
    cases.refused("region: a folder", &[&verify[..], &[&folder]].concat(), &["folder"]);
    cases.refused(
        "region: without an end",
        &[&verify[..], &["/dev/zero"]].concat(),
        &["/dev/zero"],
    );
}

/// What a report cannot show.
fn reports(cases: &mut Cases) {
    let mut folder_with = |name: &str, part: &str, content: &str, words: &[&str]| {
        let file = cases.file(part, content);
        let folder = text(Path::new(&file).parent().expect("a folder"));
        cases.refused_as_it_is(name, &["report", &folder], words);
    };
    for (turn, part) in PARTS.into_iter().enumerate() {
        folder_with("report: a part that is empty", part, "", &[part]);
        let (name, content) = [
            ("report: a part that is truncated", "{\"schema\": \"x\"".to_owned()),
            ("report: a part of another schema", "{\"schema\": \"x/9\"}".to_owned()),
            ("report: a part of another type", "[3]".to_owned()),
            ("report: a deep part", deep()),
            ("report: a part with a huge number", "{\"schema\": 1e999}".to_owned()),
        ][turn % 5]
            .clone();
        folder_with(name, part, &content, &[part]);
    }
    folder_with("report: nothing to show", "notes.txt", "", &["nothing that a report shows"]);
    let file = cases.file("diagnosis.json", "{}");
    cases.refused_as_it_is("report: of a file", &["report", &file], &["diagnosis.json"]);
    cases.refused_as_it_is("report: of nothing", &["report", "nowhere"], &["nowhere"]);
}

/// What one command wrote and another reads.
fn others(cases: &mut Cases) {
    let cohort = repository("fixtures/embedded/cohort");
    let manifest = |stage: &str, config: &str| {
        format!(
            "{{\"schema\":\"manifest/1\",\"stage\":\"{stage}\",\"command\":\"x\",\"version\":\"0.1.0\",\
             \"config\":{config},\"seed\":1,\"inputs\":[],\"outputs\":[]}}"
        )
    };
    let twin = |days: &str| {
        manifest("twin", &format!("{{\"profile\":\"quick\",\"training_days\":{days}}}"))
    };
    for (name, manifest, words) in [
        ("twins: manifest is empty", String::new(), &["manifest", "twin"][..]),
        ("twins: manifest is truncated", twin("3")[..40].to_owned(), &["manifest", "twin"]),
        ("twins: manifest of another command", manifest("train", "{}"), &["output of 'train'"]),
        ("twins: manifest without a profile", manifest("twin", "{}"), &["twin"]),
        ("twins: no model", twin("3"), &["population.safetensors"]),
        (
            "twins: days of the manifest are huge",
            twin("99999999999999"),
            &["population.safetensors"],
        ),
    ] {
        let file = cases.file("manifest.json", manifest);
        let folder = text(Path::new(&file).parent().expect("a folder"));
        cases.refused(name, &["evaluate", "--cohort", &cohort, "--twins", &folder], words);
    }
    let diagnose = ["diagnose", "--cohort", &cohort];
    for (name, content) in [("garbage", "garbage"), ("empty", "")] {
        let file = cases.file("posterior.safetensors", content);
        let typed = [&diagnose[..], &["--posterior", &file]].concat();
        cases.refused(&format!("posterior: {name}"), &typed, &["posterior.safetensors"]);
    }
    let typed = [&diagnose[..], &["--posterior", "/dev/zero"]].concat();
    cases.refused("posterior: without an end", &typed, &["/dev/zero"]);

    for (name, labels, words) in [
        ("labels: truncated", "[{", &["labels.json"][..]),
        ("labels: another schema", "{\"schema\": \"blind_labels/9\"}", &["labels.json"]),
        ("labels: empty", "", &["labels.json"]),
        ("labels: another type", "3", &["labels.json"]),
    ] {
        let file = cases.file("labels.json", labels);
        let folder = text(Path::new(&file).parent().expect("a folder"));
        cases.refused(name, &["evidence", "--labelled", &folder], words);
    }
    for (name, file, content) in [
        ("evidence: no table", "notes.txt", ""),
        ("evidence: names are truncated", "names.json", "[\"a\""),
    ] {
        let file = cases.file(file, content);
        let folder = text(Path::new(&file).parent().expect("a folder"));
        cases.refused(name, &["train-posterior", "--table", &folder], &[&folder]);
    }
    let twins = repository("fixtures/embedded");
    let file = cases.file("baselines.json", "{\"schema\":\"baselines/1\"");
    let folder = text(Path::new(&file).parent().expect("a folder"));
    cases.refused(
        "baselines: twins are none",
        &["evaluate", "--cohort", &cohort, "--twins", &twins, "--baselines", &folder],
        &["manifest"],
    );
}

/// Damaged tables of `simulate` and `baselines`.
fn tables_of_simulate(cases: &mut Cases) {
    let golden = |name: &str| repository(&format!("fixtures/golden/{name}"));
    let patients = fs::read_to_string(golden("patients.csv")).expect("there");
    let meals = fs::read_to_string(golden("meals.csv")).expect("there");
    let header = patients.lines().next().expect("a header").to_owned();
    let first = patients.lines().nth(1).expect("a patient").to_owned();
    let cell = |column: &str, value: &str| {
        let index = header.split(',').position(|name| name == column).expect("a column");
        let cells: Vec<&str> =
            first.split(',').enumerate().map(|(i, c)| if i == index { value } else { c }).collect();
        format!("{header}\n{}\n", cells.join(","))
    };
    for (name, table, words) in [
        ("empty", String::new(), &["patients.csv", "no data row"][..]),
        ("header only", format!("{header}\n"), &["patients.csv", "no data row"]),
        ("cut off", format!("{header}\n{}\n", &first[..first.len() / 2]), &["row 2", "cut off"]),
        ("other columns", "a,b\n1,2\n".to_owned(), &["patients.csv", "no column"]),
        ("text", cell("weight_kg", "heavy"), &["row 2", "weight_kg", "heavy"]),
        ("NaN", cell("vg_l_kg", "NaN"), &["row 2", "vg_l_kg"]),
        ("zero weight", cell("weight_kg", "0"), &["row 2", "weight_kg", "positive"]),
        ("negative volume", cell("vg_l_kg", "-1"), &["row 2"]),
        ("formula", cell("ag", "=1"), &["row 2", "ag"]),
        ("twice", format!("{header}\n{first}\n{first}\n"), &["row 3", "twice"]),
        ("insulin of 1e300 U", cell("tdir_u", "1e300"), &["patient"]),
    ] {
        let file = cases.file("patients.csv", table);
        let typed =
            ["simulate", "--patients", &file, "--meals", &golden("meals.csv"), "--days", "1"];
        cases.refused(&format!("patients: {name}"), &typed, words);
    }
    let header = meals.lines().next().expect("a header").to_owned();
    for (name, table, words) in [
        ("empty", String::new(), &["meals.csv", "no data row"][..]),
        ("negative", format!("{header}\n10,-50\n"), &["row 2", "carbs_g"]),
        ("half a step", format!("{header}\n1.5,50\n"), &["row 2", "step", "whole number"]),
        ("before the start", format!("{header}\n-1,50\n"), &["row 2", "step"]),
        ("infinite", format!("{header}\n10,inf\n"), &["row 2", "carbs_g"]),
        ("of 1e300 g", format!("{header}\n10,1e300\n"), &["carbs_g"]),
    ] {
        let file = cases.file("meals.csv", table);
        let typed =
            ["simulate", "--patients", &golden("patients.csv"), "--meals", &file, "--days", "1"];
        cases.refused(&format!("meals: {name}"), &typed, words);
    }
}
