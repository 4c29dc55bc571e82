//! BabelBetes.

use cohort::{Channel, ImportFormat};

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
