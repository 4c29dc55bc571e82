//! BabelBetes.

use cohort::{CellKind, Cells, Channel, ImportFormat, ParquetSink, import};

use super::{check, fixture, refusal};

const FORMAT: ImportFormat = ImportFormat::Babelbetes;

#[test]
fn the_morning_is_read() {
    let import = check(FORMAT, &[Channel::Cgm, Channel::Basal, Channel::Bolus, Channel::Carbs]);
    assert_eq!(import.cohort.people[0].id, "Flair-p1");
}

#[test]
fn broken_files_are_refused() {
    let folder = fixture("babelbetes").join("study_name=Flair");
    let cgm =
        std::fs::read(folder.join("data_type=cgm/patient_id=p1/part-0.parquet")).expect("readable");
    let basal = std::fs::read(folder.join("data_type=basal/patient_id=p1/part-0.parquet"))
        .expect("readable");
    for (name, bytes, says) in [
        ("cgm.parquet", &cgm[..], "cgm.parquet: no column 'patient_id'; found datetime, cgm"),
        ("data_type=cgm/patient_id=p1/a.parquet", &cgm[..80], "a.parquet: not a readable table"),
        ("data_type=cgm/patient_id=p1/a.parquet", &basal, "no column 'cgm'; found datetime, basal"),
        ("data_type=cgm/patient_id==1/a.parquet", &cgm, "column patient_id: '' is not an ident"),
        ("data_type=basal/patient_id=p1/a.parquet", &basal, "no cgm.parquet and no folder"),
    ] {
        let message = refusal(FORMAT, &[(name, bytes)]);
        assert!(message.contains(says), "{says}: {message}");
    }
}

/// A table of readings with a column for the person.
fn readings(patient: &'static str) -> Vec<u8> {
    let columns =
        [("patient_id", CellKind::Word), ("datetime", CellKind::Word), ("cgm", CellKind::Number)];
    let mut bytes = Vec::new();
    let mut sink = ParquetSink::new("cgm.parquet", &mut bytes, &columns).expect("a table");
    let cells = vec![
        Cells::Words(vec![patient]),
        Cells::Words(vec!["2024-03-01 08:00:00"]),
        Cells::Numbers(vec![Some(120.0)]),
    ];
    sink.write(cells).expect("writable");
    sink.finish().expect("writable");
    bytes
}

#[test]
fn the_study_is_part_of_the_name_also_where_a_column_names_the_patient() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for study in ["A", "B"] {
        let part = folder.path().join(format!("study_name={study}/data_type=cgm"));
        std::fs::create_dir_all(&part).expect("writable");
        std::fs::write(part.join("x.parquet"), readings("1")).expect("writable");
    }
    let import = import(FORMAT, folder.path()).expect("two people");
    let ids: Vec<&str> = import.cohort.people.iter().map(|person| person.id.as_str()).collect();
    assert_eq!(ids, ["A-1", "B-1"]);
    // A row without a patient is nobody's.
    let message = refusal(FORMAT, &[("study_name=A/data_type=cgm/x.parquet", &readings(""))]);
    assert!(message.contains("row 1, column patient_id: '' is not an identifier"), "{message}");
}
