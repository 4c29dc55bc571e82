//! simglucose.

use cohort::{ImportFormat, import, read_folder};

use super::{fixture, notes, refusal};

const FORMAT: ImportFormat = ImportFormat::Simglucose;

#[test]
fn the_morning_is_read_with_insulin_as_one_rate() {
    let import = import(FORMAT, &fixture("simglucose")).expect("a good fixture");
    let truth = read_folder(&fixture("expected")).expect("a good cohort");
    let (record, truth) = (&import.cohort.people[0].record, &truth.people[0].record);
    assert_eq!(import.cohort.people[0].id, "adult-001");
    assert_eq!(record.cgm(), truth.cgm());
    let close = |found: Option<f64>, expected: f64| {
        assert!(found.is_some_and(|found| (found - expected).abs() < 1e-9), "{found:?}"); // sums
    };
    for k in 0..truth.len() {
        let bolus = truth.bolus()[k].expect("recorded");
        close(record.basal()[k], truth.basal()[k].expect("recorded") + 12.0 * bolus);
        close(record.carbs()[k], truth.carbs()[k].unwrap_or(0.0));
        assert_eq!(record.bolus()[k], Some(0.0));
    }
    assert!(notes(&import).contains("the rate includes boluses"));
}

#[test]
fn samples_of_three_minutes_keep_every_amount() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("adult#002.csv");
    let text = "Time,BG,CGM,CHO,insulin\n2017-12-31 06:00:00,138,160,0.0,0.02\n\
                2017-12-31 06:03:00,138,150,10.0,0.5\n2017-12-31 06:06:00,138,140,0.0,0.02\n\
                2017-12-31 06:09:00,138,130,0.0,0.02\n2017-12-31 06:12:00,138,120,,\n";
    std::fs::write(&file, text).expect("writable");
    let record = &import(FORMAT, &file).expect("good").cohort.people[0].record;
    // The nearest reading: 06:00, 06:06, 06:09.
    assert_eq!(record.cgm(), [Some(160.0), Some(140.0), Some(130.0)]);
    // 10 g/min for 3 min, of which two before 06:05.
    assert_eq!(record.carbs()[..2], [Some(20.0), Some(10.0)]);
    // (3 x 0.02 + 2 x 0.5) U in the first step.
    let rate = record.basal()[0].expect("recorded");
    assert!((rate - 12.0 * 1.06).abs() < 1e-9, "{rate}"); // sums
}

#[test]
fn broken_files_are_refused_with_their_place() {
    let row = "2017-12-31 06:00:00,160,0.0,0.02\n";
    for (rows, says) in [
        (String::new(), "adult#001.csv: no data row"),
        (row.repeat(2), "row 3, column Time: '2017-12-31 06:00:00' is not later than the row"),
        ("31/12/2017,160,0.0,0.02\n".into(), "row 2, column Time: '31/12/2017' is not a time"),
        ("2017-12-31 06:00:00,x,0.0,0.02\n".into(), "column CGM: 'x' is not a number"),
        (format!("2017-12-31 05:57:00,160,0.0,-1\n{row}"), "column insulin: -60 is outside 0 to"),
        ("2017-12-31 06:00:00,160\n".into(), "row 2: 2 fields where the header has 4"),
    ] {
        let text = format!("Time,CGM,CHO,insulin\n{rows}");
        let message = refusal(FORMAT, &[("adult#001.csv", text.as_bytes())]);
        assert!(message.contains(says), "{rows}: {message}");
    }
}

#[test]
fn two_files_that_give_one_name_are_refused() {
    let text = b"Time,CGM,CHO,insulin\n2017-12-31 06:00:00,160,0.0,0.02\n";
    let message = refusal(FORMAT, &[("adult#001.csv", text), ("adult-001.csv", text)]);
    let says = "would be called 'adult-001', as that of 'adult#001.csv'; rename one of the files";
    assert!(message.starts_with("adult-001.csv") && message.contains(says), "{message}");
}
