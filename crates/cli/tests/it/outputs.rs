//! Every JSON file that a command writes is what its schema says, and nothing of it is lost on reading.

use std::fs;
use std::path::Path;

use contract::blind_check::{BlindCheck, PlantedCheck, Realism, Seal};
use contract::{
    Conformance, DataInUse, Diagnosis, Document, ExampleDay, GlucoseProfile, Manifest,
    OutcomesTable, Training, TwinsTable, WhatIf, read,
};
use serde_json::Value;

/// Files whose types belong to a crate of their own, or to the importer of a study.
const OTHERS: [&str; 7] = [
    "region.json",
    "certificates.json",
    "held-out.json",
    "baselines.json",
    "import_report.json",
    "labels.json",
    "run_errors.json",
];

/// Reads every JSON file in `folder` and the folders within by its schema; returns how many there were.
pub(crate) fn checked(folder: &Path) -> usize {
    let mut count = 0;
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            count += checked(&path);
        } else if path.extension().is_some_and(|extension| extension == "json") {
            file(&path);
            count += 1;
        }
    }
    count
}

fn file(path: &Path) {
    let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
    let bytes = fs::read(path).expect("readable");
    let place = path.display();
    match name {
        _ if path.parent().is_some_and(|folder| folder.ends_with("answers")) => {
            whole::<Diagnosis>(&bytes, path);
        }
        Manifest::FILE => whole::<Manifest>(&bytes, path),
        Training::FILE => whole::<Training>(&bytes, path),
        Conformance::FILE => whole::<Conformance>(&bytes, path),
        TwinsTable::FILE => whole::<TwinsTable>(&bytes, path),
        OutcomesTable::FILE => whole::<OutcomesTable>(&bytes, path),
        GlucoseProfile::FILE => whole::<GlucoseProfile>(&bytes, path),
        WhatIf::FILE | "what_if_constrained.json" => whole::<WhatIf>(&bytes, path),
        ExampleDay::FILE => whole::<ExampleDay>(&bytes, path),
        DataInUse::FILE => whole::<DataInUse>(&bytes, path),
        Diagnosis::<Value>::FILE => whole::<Diagnosis>(&bytes, path),
        BlindCheck::FILE => whole::<BlindCheck>(&bytes, path),
        Seal::FILE => whole::<Seal>(&bytes, path),
        PlantedCheck::FILE => whole::<PlantedCheck>(&bytes, path),
        Realism::FILE => whole::<Realism>(&bytes, path),
        other => assert!(OTHERS.contains(&other), "'{place}' has no schema"),
    }
}

/// The document as it is read, written again, is what lies there.
fn whole<T: Document>(bytes: &[u8], path: &Path) {
    let document: T = read(bytes).unwrap_or_else(|error| panic!("'{}': {error}", path.display()));
    let again = serde_json::to_value(&document).expect("JSON");
    let found: Value = serde_json::from_slice(bytes).expect("JSON");
    assert!(again == found, "'{}': not the same when it is written again", path.display());
}
