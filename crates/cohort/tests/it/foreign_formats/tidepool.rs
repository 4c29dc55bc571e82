//! Tidepool.

use cohort::{Channel, ImportFormat, import};

use super::{check, notes};

#[test]
fn the_morning_is_read() {
    let import = check(
        ImportFormat::Tidepool,
        &[Channel::Cgm, Channel::Basal, Channel::Bolus, Channel::Carbs, Channel::SetChange],
    );
    let notes = notes(&import);
    for says in [
        "p1.json, column basal_u_h: rates that a later one ends (1x)",
        "column formulation: injections that are not rapid insulin: left out (1x)",
        "data with an id that came before: left out (2x)",
    ] {
        assert!(notes.contains(says), "{says} is not in\n{notes}");
    }
}

fn read(text: &str) -> Result<cohort::Import, cohort::CohortError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("p1.json");
    std::fs::write(&file, text).expect("writable");
    import(ImportFormat::Tidepool, &file)
}

#[test]
fn a_meal_in_food_and_calculator_is_pointed_out() {
    let text = r#"[
        {"type":"cbg","units":"mg/dL","value":100,"deviceTime":"2024-03-01T08:00:00"},
        {"type":"wizard","carbInput":40,"deviceTime":"2024-03-01T08:01:00"},
        {"type":"food","nutrition":{"carbohydrate":{"net":40}},"deviceTime":"2024-03-01T08:02:00"}]"#;
    let import = read(text).expect("good data");
    assert_eq!(import.cohort.people[0].record.carbs(), [Some(80.0)]);
    assert!(notes(&import).contains("row 3, column nutrition.carbohydrate.net: food like a bolus"));
}

#[test]
fn broken_data_are_refused_with_their_place() {
    let time = "\"deviceTime\":\"2024-03-01T08:00:00\"";
    for (text, says) in [
        (String::new(), "p1.json: no data row"),
        ("[{\"type\":\"cbg\",".into(), "record 1: EOF"),
        ("[{\"value\":5}]".into(), "row 1, column type: '' is not the kind of datum"),
        (format!("[{{\"type\":\"cbg\",\"value\":5,{time}}}]"), "column units: '' is not mmol/L"),
        (
            format!("[{{\"type\":\"cbg\",\"units\":\"mmol/L\",\"value\":\"five\",{time}}}]"),
            "p1.json, row 1, column value: 'five' is not a number",
        ),
        (
            format!("[{{\"type\":\"cbg\",\"units\":\"mmol/L\",\"value\":100000,{time}}}]"),
            "column value: 1801559 is outside 0 to 2000 mg/dL",
        ),
        (
            "[{\"type\":\"basal\",\"rate\":1,\"time\":\"2024-03-01T08:00:00Z\"}]".into(),
            "column deviceTime: '' is not a local time; deviceTime, timezoneOffset and timezone",
        ),
        (
            format!("[{{\"type\":\"bolus\",\"extended\":1,\"duration\":-5,{time}}}]"),
            "column duration: '-5' is not milliseconds",
        ),
        (format!("[{{\"type\":\"bolus\",{time}}}]"), "column normal: '' is not U"),
        (
            format!("[{{\"type\":\"wizard\",\"carbInput\":3,\"carbUnits\":\"exchanges\",{time}}}]"),
            "column carbUnits: 'exchanges' is not grams",
        ),
        (
            "[{\"type\":\"basal\",\"rate\":1,\"deviceTime\":\"2024-13-01T08:00:00\"}]".into(),
            "column deviceTime: '2024-13-01T08:00:00' is not a local time",
        ),
        (format!("[{{\"type\":\"bolus\",\"normal\":1,{time}}}]"), "no sensor reading of anyone"),
    ] {
        let message = read(&text).expect_err("refused").to_string();
        assert!(message.contains(says), "{text}: {message}");
    }
}
