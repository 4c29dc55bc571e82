//! The importers on the real people of the reference data, judged person by person.

use std::path::Path;

use cohort::{
    Import, ImportFormat, MissingDoses, RecordsFormat, Therapy, import, read_folder, write_folder,
};

fn read(format: ImportFormat, path: &Path) -> Import {
    let started = std::time::Instant::now();
    let read = import(format, path).expect("the reference data import");
    eprintln!("{}: {:.2?}", format.name(), started.elapsed());
    for person in &read.report.people {
        eprintln!("  {} [{}]", person.line, person.therapy);
        for totals in &person.totals {
            eprintln!("    {totals:?}");
            assert!(totals.closes(), "{totals:?}");
        }
        for finding in person.findings.iter().take(5) {
            eprintln!("    finding: {finding}");
        }
    }
    for inference in &read.report.inferences {
        eprintln!("  {inference}");
    }
    for note in &read.report.notes {
        eprintln!("  {note}");
    }
    read
}

#[test]
fn hupa_ucm() {
    let Some(path) = reference_data::find("hupa_ucm", "hupa_ucm") else { return };
    let import = read(ImportFormat::HupaUcm, &path);
    assert_eq!(import.cohort.people.len(), 8);
}

#[test]
fn t1d_uom() {
    let Some(path) = reference_data::find("t1d_uom", "t1d_uom") else { return };
    let import = read(ImportFormat::T1dUom, &path);
    assert_eq!(import.cohort.people.len(), 3);
}

#[test]
fn t1dsim() {
    let Some(path) = reference_data::find("t1dsim_ai/example_subjectX.csv", "t1dsim") else {
        return;
    };
    let import = read(ImportFormat::T1dSim, &path);
    assert_eq!(import.cohort.people.len(), 1);
    let _ = (MissingDoses::Error, RecordsFormat::Csv, Therapy::Aid, read_folder, write_folder);
}
