//! What cannot be a person is neither trained on, nor judged, nor diagnosed, and every stage says the same of it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use cohort::{Channel, Cohort, Person, RecordsFormat, read_folder, write_folder};
use contract::{DataInUse, Diagnosis, Document, OutcomesTable, TwinsTable, read};

use crate::outputs;

fn xtask(arguments: &[&str]) -> (bool, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_t1d-twins")).args(arguments).output();
    let output = output.expect("the program starts");
    (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn text(path: &Path) -> &str {
    path.to_str().expect("temporary paths are UTF-8")
}

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn document<T: Document>(folder: &Path) -> T {
    read(&fs::read(folder.join(T::FILE)).expect("written")).expect("by its schema")
}

/// Twelve days of four people: one of them is a flat line, one has 98 % of the readings drawn.
fn mixed() -> Cohort {
    let embedded = read_folder(&workspace().join("fixtures/embedded/cohort")).expect("reads");
    let cut = |person: &Person| {
        let record = person.record.slice(0..12 * 288).expect("inside the record");
        Person { record, ..person.clone() }
    };
    let mut people: Vec<Person> = embedded.people.iter().take(4).map(cut).collect();
    let flat = people[1].record.channel_mut(Channel::Cgm);
    flat.iter_mut().for_each(|value| *value = value.map(|_| 120.0));
    let drawn = people[3].record.channel_mut(Channel::Cgm);
    let old = drawn.to_vec();
    for (k, value) in drawn.iter_mut().enumerate() {
        let (from, to) = (k / 48 * 48, (k / 48 * 48 + 48).min(old.len() - 1));
        let [a, b] = [from, to].map(|k| old[k].unwrap_or(140.0));
        *value = Some(a + (b - a) * (k - from) as f64 / (to - from).max(1) as f64);
    }
    Cohort { people }
}

#[test]
fn what_one_person_of_a_cohort_shows_alone_has_no_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let embedded = read_folder(&workspace().join("fixtures/embedded/cohort")).expect("reads");
    let alone: Vec<Person> = embedded.people.into_iter().filter(|p| p.id == "P04").collect();
    let mut short = Person { id: "short".into(), ..alone[0].clone() };
    short.record = short.record.slice(0..288).expect("a day");
    short.record.channel_mut(Channel::Cgm).iter_mut().flatten().for_each(|glucose| *glucose += 1.0);
    let diagnosed = |name: &str, people: Vec<Person>| -> Diagnosis {
        let (cohort, out) = (folder.path().join(name), folder.path().join(format!("{name}-out")));
        write_folder(&Cohort { people }, &cohort, RecordsFormat::Csv).expect("writable");
        let (done, said) = xtask(&["diagnose", "--cohort", text(&cohort), "--out", text(&out)]);
        assert!(done, "{said}");
        document(&out)
    };
    let one = diagnosed("one", alone.clone());
    assert!(one.effects.iter().any(|found| found.effect == "missed_meals"), "{:?}", one.effects);
    let of_two = diagnosed("of-two", [alone, vec![short]].concat());
    assert!(of_two.effects.is_empty(), "{:?}", of_two.effects);
    assert_eq!(of_two.verdict, contract::diagnosis::Verdict::Unknown);
    let meals = of_two.candidates.iter().find(|c| c.effect == "missed_meals").expect("tried");
    let why = meals.not_named.as_deref().unwrap_or_default();
    assert!(why.starts_with("It rests on one person: without P04 its probability is "), "{why}");
}

#[test]
fn a_twin_of_people_without_basal_insulin_is_left_out_by_name_and_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let model = workspace().join("crates/nn-statespace/model/population.safetensors");
    let mut cohort = mixed();
    cohort.people.retain(|person| person.id == "P01" || person.id == "P03");
    for (name, without) in [("nobody", 2), ("one", 1)] {
        let mut cohort = cohort.clone();
        for person in cohort.people.iter_mut().take(without) {
            person.record.channel_mut(Channel::Basal).fill(None);
        }
        let (place, out) = (at(name), at(&format!("{name}-twins")));
        write_folder(&cohort, &place, RecordsFormat::Parquet).expect("writable");
        let typed = ["twin", "--cohort", text(&place), "--model", text(&model)];
        let (done, said) = xtask(&[&typed[..], &["--epochs", "1", "--out", text(&out)]].concat());
        // The folder of twins says who has none: the work is done.
        assert!(done, "{said}");
        for person in ["P01", "P03"].iter().take(without) {
            let says = format!("twin: {person} left out: ");
            let line = said.lines().find(|line| line.starts_with(&says));
            assert!(line.is_some_and(|line| line.contains("basal")), "{says}\n{said}");
        }
        let (trained, out_of) = (2 - without, if without == 1 { "1 person" } else { "2 people" });
        let sum =
            format!("{trained} {}, {out_of} left out", if trained == 1 { "twin" } else { "twins" });
        assert!(said.contains(&sum), "{sum}\n{said}");
        let last = said.lines().last().unwrap_or_default();
        let next =
            if trained > 0 { " evaluate --cohort " } else { "read why nobody has a twin in " };
        assert!(last.starts_with("next: ") && last.contains(next), "{last}");
        let table: TwinsTable = document(&out);
        let excluded = table.people.iter().filter(|row| row.excluded.is_some()).count();
        assert_eq!((table.people.len(), excluded), (2, without));
    }
}

#[test]
fn every_stage_leaves_the_same_people_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    write_folder(&mixed(), &at("cohort"), RecordsFormat::Parquet).expect("writable");
    let (cohort, twin, evaluate, diagnose) =
        (at("cohort"), at("twin"), at("evaluate"), at("diagnose"));
    let model = workspace().join("crates/nn-statespace/model/population.safetensors");
    let common = ["--cohort", text(&cohort)];
    let run = |arguments: &[&str]| {
        let (done, said) = xtask(&[arguments, &common[..]].concat());
        assert!(done, "{arguments:?}: {said}");
        said
    };
    let said = run(&["twin", "--model", text(&model), "--epochs", "1", "--out", text(&twin)]);
    assert!(said.contains("data: 2 of 4 people in use"), "{said}");
    assert!(said.contains("fail: flat_cgm"), "{said}");
    run(&["evaluate", "--twins", text(&twin), "--out", text(&evaluate), "-q"]);
    let said = run(&["diagnose", "--out", text(&diagnose)]);
    for reason in
        ["diagnose: P02 left out: flat_cgm: ", "diagnose: P04 left out: interpolated_cgm: "]
    {
        assert!(said.contains(reason), "{reason}: {said}");
    }

    let list: DataInUse = document(&twin);
    for other in [&evaluate, &diagnose] {
        assert_eq!(list, document(other), "{}", other.display());
        outputs::checked(other);
    }
    let left_out: Vec<(&str, &str)> = list
        .people
        .iter()
        .filter_map(|person| Some((person.person_id.as_str(), person.left_out.as_deref()?)))
        .collect();
    let names: Vec<&str> = left_out.iter().map(|(id, _)| *id).collect();
    assert_eq!(names, ["P02", "P04"]);
    assert!(left_out[0].1.starts_with("flat_cgm: "), "{left_out:?}");
    assert!(left_out[1].1.starts_with("interpolated_cgm: "), "{left_out:?}");

    let twins: TwinsTable = document(&twin);
    let outcomes: OutcomesTable = document(&evaluate);
    let diagnosis: Diagnosis = document(&diagnose);
    assert_eq!((twins.people.len(), outcomes.people), (4, 2));
    for (id, reason) in left_out {
        let row = twins.people.iter().find(|row| row.person_id == id).expect("a row");
        assert_eq!((row.excluded.as_deref(), row.loss_first), (Some(reason), None));
        assert!(!twin.join(format!("twins/{id}.safetensors")).exists(), "{id}");
        let row = outcomes.exclusions.iter().find(|row| row.person_id == id).expect("a row");
        assert_eq!(row.reason, reason);
        let row = diagnosis.people.iter().find(|row| row.person_id == id).expect("a row");
        assert_eq!(row.excluded.as_deref(), Some(reason));
    }
    assert!(twin.join("twins/P01.safetensors").is_file());
}

#[test]
fn one_person_is_judged_and_told_why_there_is_no_table_of_outcomes() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let mut alone = mixed();
    alone.people.truncate(1);
    write_folder(&alone, &at("cohort"), RecordsFormat::Parquet).expect("writable");
    let model = workspace().join("crates/nn-statespace/model/population.safetensors");
    let (cohort, twin, evaluate) = (at("cohort"), at("twin"), at("evaluate"));
    let run = |arguments: &[&str]| {
        let (done, said) = xtask(&[arguments, &["--cohort", text(&cohort)]].concat());
        assert!(done, "{arguments:?}: {said}");
        said
    };
    run(&["twin", "--model", text(&model), "--epochs", "1", "--out", text(&twin)]);
    let twins: TwinsTable = document(&twin);
    assert!(twins.people[0].rmse_twin.is_some_and(f64::is_finite), "{twins:?}");
    let said = run(&["evaluate", "--twins", text(&twin), "--out", text(&evaluate)]);
    assert!(
        said.contains("evaluate: 1 judged; outcomes are tests over people and need 2"),
        "{said}"
    );
    assert!(!evaluate.join(OutcomesTable::FILE).exists());
}
