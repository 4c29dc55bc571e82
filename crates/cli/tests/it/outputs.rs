//! Every JSON file that a command writes is what its type says, and nothing of it is lost on reading.

use std::fs;
use std::path::{Path, PathBuf};

use contract::bench::{DiagnosisBench, MealsBench, TrainingStepBench, TwinsBench};
use contract::blind_check::{
    Answer, BlindCheck, CalibrationTable, Label, Labels, OpenedLabels, People, PlantedCheck,
    Realism, Seal,
};
use contract::development_set::{DevelopmentSetSummary, ScalerSummary};
use contract::posterior::{PosteriorCard, StatisticNames};
use contract::{
    Baselines, Certificates, Conformance, DataInUse, Diagnosis, Document, EffectTwins, ExampleDay,
    Exclusions, GlucoseByPerson, GlucoseProfile, HeldOut, ImportReport, Manifest, Meals,
    OutcomesTable, RegionFile, Repair, RunErrors, StatedTruth, SteadyStates, Thresholds, Training,
    Trajectories, TwinsTable, WhatIf, WidthSearch, read,
};
use serde_json::Value;

/// Reads a file by one type and writes it again; says what is wrong.
type Check = fn(&[u8]) -> Result<(), String>;

/// The file of a document, and its check.
fn document<T: Document>() -> (&'static str, Check) {
    (T::FILE, whole::<T>)
}

/// Every document. Two or more share a name where several commands write a file of this name.
fn documents() -> Vec<(&'static str, Check)> {
    vec![
        document::<Manifest>(),
        document::<ImportReport>(),
        document::<DevelopmentSetSummary>(),
        document::<ScalerSummary>(),
        document::<WidthSearch>(),
        document::<Training>(),
        document::<RegionFile>(),
        document::<Conformance>(),
        document::<Certificates>(),
        document::<Repair>(),
        document::<HeldOut>(),
        document::<SteadyStates>(),
        document::<Trajectories>(),
        document::<TwinsTable>(),
        document::<RunErrors>(),
        document::<Baselines>(),
        document::<OutcomesTable>(),
        document::<Exclusions>(),
        document::<GlucoseProfile>(),
        document::<WhatIf>(),
        document::<ExampleDay>(),
        document::<DataInUse>(),
        document::<GlucoseByPerson>(),
        document::<StatedTruth>(),
        document::<Diagnosis>(),
        document::<EffectTwins>(),
        document::<Meals>(),
        document::<BlindCheck>(),
        document::<Seal>(),
        document::<Answer>(),
        document::<OpenedLabels>(),
        document::<Label>(),
        document::<Labels>(),
        document::<CalibrationTable>(),
        document::<Thresholds>(),
        document::<PlantedCheck>(),
        document::<Realism>(),
        document::<People>(),
        document::<StatisticNames>(),
        document::<PosteriorCard>(),
        document::<DiagnosisBench>(),
        document::<MealsBench>(),
        document::<TrainingStepBench>(),
        document::<TwinsBench>(),
    ]
}

/// Reads every JSON file in `folder` and the folders within by its type; returns how many there were.
pub(crate) fn checked(folder: &Path) -> usize {
    let (count, faults) = read_all(folder);
    assert!(faults.is_empty(), "{faults:#?}");
    count
}

/// How many JSON files there are, and those that have no type or do not fit it.
fn read_all(folder: &Path) -> (usize, Vec<String>) {
    let mut files = Vec::new();
    collect(folder, &mut files);
    let documents = documents();
    let faults = files.iter().filter_map(|file| {
        let fault = fault(file, &documents)?;
        Some(format!("'{}': {fault}", file.display()))
    });
    (files.len(), faults.collect())
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "json") {
            files.push(path);
        }
    }
}

/// What is wrong with a file.
fn fault(path: &Path, documents: &[(&str, Check)]) -> Option<String> {
    let names = document_names(path);
    let bytes = fs::read(path).expect("readable");
    let mut found = "it has no type".to_owned();
    for (_, check) in documents.iter().filter(|(file, _)| names.contains(file)) {
        match check(&bytes) {
            Ok(()) => return None,
            Err(fault) => found = fault,
        }
    }
    Some(found)
}

/// The documents that may lie under this name.
fn document_names(path: &Path) -> Vec<&str> {
    let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
    if path.parent().is_some_and(|folder| folder.ends_with("answers")) {
        return vec![Diagnosis::<Value>::FILE, Answer::FILE];
    }
    match name {
        "what_if_constrained.json" => vec![WhatIf::FILE],
        card if card.starts_with("without-") => vec![PosteriorCard::FILE],
        own => vec![own],
    }
}

/// The document as it is read, written again, is what lies there.
fn whole<T: Document>(bytes: &[u8]) -> Result<(), String> {
    let document: T = read(bytes).map_err(|error| error.to_string())?;
    let again = serde_json::to_value(&document).map_err(|error| error.to_string())?;
    let found: Value = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
    if again == found { Ok(()) } else { Err("not the same when it is written again".to_owned()) }
}

#[test]
fn a_file_without_a_type_and_one_that_does_not_fit_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).expect("writable");
    fs::write(inner.join(Labels::FILE), "[]").expect("writable");
    assert_eq!(read_all(folder.path()), (1, Vec::new()));
    for (name, text, says) in [
        ("own.json", "{}", "own.json': it has no type"),
        (RunErrors::FILE, r#"{"p1": {"left": 0.5}}"#, "missing field `added`"),
        (Seal::FILE, r#"{"schema": "seal/1", "hash": "", "worlds": [], "more": 1}"#, "`more`"),
        (Seal::FILE, r#"{"schema": "seal/0", "hash": "", "worlds": []}"#, "its schema is 'seal/0'"),
    ] {
        let file = inner.join(name);
        fs::write(&file, text).expect("writable");
        let (count, faults) = read_all(folder.path());
        assert_eq!(count, 2);
        assert!(faults.len() == 1 && faults[0].contains(says), "{name}: {faults:?}");
        fs::remove_file(&file).expect("removable");
    }
}
