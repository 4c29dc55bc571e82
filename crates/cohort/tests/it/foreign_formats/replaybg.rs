//! ReplayBG.

use cohort::{Channel, ImportFormat, import};

use super::{check, refusal};

const FORMAT: ImportFormat = ImportFormat::Replaybg;

#[test]
fn the_morning_is_read() {
    check(FORMAT, &[Channel::Cgm, Channel::Basal, Channel::Bolus, Channel::Carbs]);
}

#[test]
fn broken_files_are_refused_with_their_place() {
    let row = "2024-03-01 08:00:00,120,0,0,0.01\n";
    for (rows, says) in [
        (String::new(), "p1.csv: no data row"),
        (row.repeat(2), "p1.csv, row 3, column t: person 'p1' has two rows"),
        (format!("2024-03-01 08:05:00,1,0,0,0\n{row}"), "row 3, column t: person 'p1' at 2024"),
        ("2024-03-01 08:01:00,120,0,0,0\n".into(), "off the 5-minute grid"),
        ("1/3/2024,120,0,0,0\n".into(), "row 2, column t: '1/3/2024' is not a time like"),
        ("2024-03-01 08:00:00,120,x,0,0\n".into(), "column cho: 'x' is not a number"),
        ("2024-03-01 08:00:00,120,0,-1,0\n".into(), "column bolus: -5 is outside 0 to 100 U"),
        ("2024-03-01 08:00:00,6.1,0,0,0\n".into(), "looks like mmol/L"),
    ] {
        let text = format!("t,glucose,cho,bolus,basal\n{rows}");
        let message = refusal(FORMAT, &[("p1.csv", text.as_bytes())]);
        assert!(message.contains(says), "{rows}: {message}");
    }
}

#[test]
fn a_name_loses_one_ending() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["x.csv", "x.csv.csv"] {
        let text = "t,glucose,cho,bolus,basal\n2024-03-01 08:00:00,120,0,0,0.01\n";
        std::fs::write(folder.path().join(name), text).expect("writable");
    }
    let import = import(FORMAT, folder.path()).expect("two people");
    let ids: Vec<&str> = import.cohort.people.iter().map(|person| person.id.as_str()).collect();
    assert_eq!(ids, ["x", "x.csv"]);
}
