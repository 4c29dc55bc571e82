//! MetaboNet.

use cohort::{Channel, ImportFormat, Therapy};

use super::{check, fixture, refusal};

const FORMAT: ImportFormat = ImportFormat::Metabonet;

#[test]
fn the_morning_is_read() {
    let channels = [
        Channel::Cgm,
        Channel::Basal,
        Channel::Bolus,
        Channel::Carbs,
        Channel::HeartRate,
        Channel::Steps,
    ];
    let import = check(FORMAT, &channels);
    let person = &import.cohort.people[0];
    assert_eq!((person.id.as_str(), person.therapy), ("Loop_Part_1_-p1", Therapy::OpenLoopPump));
    assert!(person.weight.is_some_and(|weight| (weight.0 - 70.0).abs() < 1e-6)); // lb and back
}

#[test]
fn broken_files_are_refused() {
    let good = std::fs::read(fixture("metabonet").join("metabonet.parquet")).expect("readable");
    let other = fixture("babelbetes/study_name=Flair/data_type=cgm/patient_id=p1/part-0.parquet");
    let other = std::fs::read(other).expect("readable");
    for (bytes, says) in [
        (&b""[..], "m.parquet"),
        (b"id,date\n1,2\n", "m.parquet: not a readable table"),
        (&good[..good.len() / 2], "m.parquet: not a readable table"),
        (&other, "m.parquet: no column 'id'; found datetime, cgm"),
    ] {
        let message = refusal(FORMAT, &[("m.parquet", bytes)]);
        assert!(message.contains(says), "{says}: {message}");
    }
    assert!(refusal(FORMAT, &[("m.csv", b"")]).contains("no file named *.parquet"));
}
