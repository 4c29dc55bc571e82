//! Exported cohorts, read back by the importers of the same formats.

use std::fs;
use std::path::Path;

use cohort::{Channel, Cohort, ExportFormat, ImportFormat, export, import, read_folder};

fn morning() -> Cohort {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/import/expected");
    read_folder(&folder).expect("a good cohort")
}

fn exported(format: ExportFormat) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    export(&morning(), format, folder.path()).expect("writable");
    folder
}

/// Exports the morning, imports it again and compares some channels.
fn round_trip(to: ExportFormat, from: ImportFormat, channels: &[Channel]) -> Cohort {
    let back = import(from, exported(to).path()).expect("readable").cohort;
    let (truth, found) = (morning(), &back.people[0].record);
    for channel in channels {
        let truth = truth.people[0].record.channel(*channel);
        for (k, (found, truth)) in found.channel(*channel).iter().zip(truth).enumerate() {
            let near = match (found, truth) {
                (Some(found), Some(truth)) => (found - truth).abs() < 1e-9, // per minute and back
                (found, truth) => found == truth,
            };
            assert!(near, "{} of step {k}: {found:?}, not {truth:?}", channel.name());
        }
    }
    back
}

#[test]
fn iglu_has_a_row_a_reading() {
    let text = fs::read_to_string(exported(ExportFormat::Iglu).path().join("iglu.csv"));
    let text = text.expect("readable");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[..2], ["id,time,gl", "p1,2024-03-01 08:00:00,120"]);
    // 48 steps, of which two have no reading, and the header.
    assert_eq!(lines.len(), 47);
}

#[test]
fn replaybg_reads_back() {
    use Channel::{Basal, Bolus, Carbs, Cgm};
    let channels = [Cgm, Basal, Bolus, Carbs];
    round_trip(ExportFormat::Replaybg, ImportFormat::Replaybg, &channels);
    let text = fs::read_to_string(exported(ExportFormat::Replaybg).path().join("p1.csv"));
    let text = text.expect("readable");
    let meal = text.lines().nth(4).expect("a row");
    assert_eq!(meal, "01-Mar-2024 08:15:00,135,9,1,0.013333333333333334,B,B,0");
}

#[test]
fn simglucose_reads_back() {
    let back = round_trip(ExportFormat::Simglucose, ImportFormat::Simglucose, &[Channel::Cgm]);
    let insulin: f64 = back.people[0].record.basal().iter().flatten().sum::<f64>() / 12.0;
    let truth = morning();
    let record = &truth.people[0].record;
    let given = record.basal().iter().flatten().sum::<f64>() / 12.0
        + record.bolus().iter().flatten().sum::<f64>();
    assert!((insulin - given).abs() < 1e-9, "{insulin} of {given}"); // rounding of sums
}

#[test]
fn metabonet_reads_back() {
    use Channel::{Basal, Bolus, Carbs, Cgm, HeartRate, Steps};
    let channels = [Cgm, Basal, Bolus, Carbs, HeartRate, Steps];
    let back = round_trip(ExportFormat::Metabonet, ImportFormat::Metabonet, &channels);
    assert_eq!(back.people[0].therapy, morning().people[0].therapy);
}
