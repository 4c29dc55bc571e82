//! Every JSON file that a command writes is what its type says, and nothing of it is lost on reading.

use std::fs;
use std::path::{Path, PathBuf};

use contract::blind_check::{Answer, Labels, Seal};
use contract::posterior::PosteriorCard;
use contract::{Diagnosis, Document as _, DocumentKind, RunErrors, WhatIf, document_kinds};
use serde_json::Value;

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
    let documents = document_kinds();
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
fn fault(path: &Path, documents: &[DocumentKind]) -> Option<String> {
    let names = document_names(path);
    let bytes = fs::read(path).expect("readable");
    let mut found = "it has no type".to_owned();
    for document in documents.iter().filter(|document| names.contains(&document.file)) {
        match document.same_again(&bytes) {
            Ok(true) => return None,
            Ok(false) => found = "not the same when it is written again".to_owned(),
            Err(fault) => found = fault.to_string(),
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
