//! Nightscout.

use cohort::{Channel, ImportFormat, Therapy, import};

use super::{check, notes, refusal};

const FORMAT: ImportFormat = ImportFormat::Nightscout;
const PROFILE: &str = r#"[{"defaultProfile":"A","startDate":"2024-01-01T00:00:00Z","store":
    {"A":{"timezone":"UTC","basal":[{"time":"00:00","value":1}]}}}]"#;

#[test]
fn the_morning_is_read() {
    let import = check(
        FORMAT,
        &[Channel::Cgm, Channel::Basal, Channel::Bolus, Channel::Carbs, Channel::SetChange],
    );
    assert_eq!(import.cohort.people[0].id, "p1");
    assert_eq!(import.cohort.people[0].therapy, Therapy::OpenLoopPump);
    let notes = notes(&import);
    for says in [
        "entries.json, row 47, column sgv: readings given twice: one is kept (1x)",
        "row 48, column type: entries that are not sensor readings: left out (1x)",
        "row 49, column sgv: readings of 12 or less: codes of the sensor, left out (1x)",
        "treatments.json, row 13, column _id: records with an _id that came before: left out (1x)",
    ] {
        assert!(notes.contains(says), "{says} is not in\n{notes}");
    }
}

/// Writes a person's files and imports them.
fn read(files: &[(&str, &str)]) -> cohort::Import {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).expect("writable");
    }
    let id = folder.path().join("p1");
    std::fs::create_dir(&id).expect("writable");
    for (name, _) in files {
        std::fs::rename(folder.path().join(name), id.join(name)).expect("writable");
    }
    import(FORMAT, folder.path()).expect("good files")
}

#[test]
fn mmol_are_recognised_and_the_offset_of_each_record_is_used() {
    // One object a line, as `mongoexport` writes them.
    let entries = "{\"sgv\":5.5,\"dateString\":\"2024-03-01T10:00:00Z\",\"utcOffset\":-300}\n\
                   {\"sgv\":6.5,\"dateString\":\"2024-03-01T05:05:00-05:00\"}\n";
    let import = read(&[("entries.json", entries)]);
    let record = &import.cohort.people[0].record;
    assert_eq!(record.start().to_string(), "2024-03-01 05:00:00");
    assert_eq!(record.cgm(), [Some(99.0), Some(117.0)]);
    let inferred =
        import.report.inferences.iter().flatten().any(|one| one.conclusion.contains("mmol/L"));
    assert!(inferred, "{:?}", import.report.inferences);
}

#[test]
fn clocks_that_change_leave_a_gap_or_a_repeated_hour() {
    let profile = PROFILE.replace("\"UTC\"", "\"Europe/Madrid\"");
    // 01:55 and 03:00 local time are five minutes apart in spring.
    let entries = r#"[{"sgv":100,"dateString":"2024-03-31T00:55:00Z"},
                      {"sgv":110,"dateString":"2024-03-31T01:00:00Z"}]"#;
    let spring = read(&[("entries.json", entries), ("profile.json", &profile)]);
    let record = &spring.cohort.people[0].record;
    assert_eq!((record.len(), record.start().to_string()), (14, "2024-03-31 01:55:00".into()));
    // 02:55 twice in autumn: the first stays.
    let entries = entries.replace("2024-03-31", "2024-10-27").replace("T01:00", "T01:55");
    let autumn = read(&[("entries.json", &entries), ("profile.json", &profile)]);
    assert_eq!(autumn.cohort.people[0].record.cgm(), [Some(100.0)]);
    assert!(notes(&autumn).contains("readings beside a nearer or earlier one"));
    // Sites write the newest entry first, and the second one may be nearer to the step.
    let newest_first = r#"[{"sgv":110,"dateString":"2024-10-27T01:55:00Z"},
                           {"sgv":100,"dateString":"2024-10-27T00:56:00Z"}]"#;
    let autumn = read(&[("entries.json", newest_first), ("profile.json", &profile)]);
    assert_eq!(autumn.cohort.people[0].record.cgm(), [Some(100.0)]);
}

#[test]
fn switches_change_the_schedule_for_a_while_or_for_good() {
    let entries: String = (0..24)
        .map(|k| format!("{{\"sgv\":100,\"date\":{}}}\n", 1_709_280_000_000_i64 + 300_000 * k))
        .collect();
    // From 08:00 UTC; 150 % for 20 min at 08:20, another profile for good at 09:00.
    let treatments = r#"[
        {"eventType":"Profile Switch","created_at":"2024-03-01T09:00:00Z","profile":"B",
         "profileJson":"{\"basal\":[{\"time\":\"00:00\",\"value\":2}]}"},
        {"eventType":"Profile Switch","created_at":"2024-03-01T08:20:00Z","profile":"A",
         "percentage":150,"duration":20}]"#;
    let import = read(&[
        ("entries.json", &entries),
        ("treatments.json", treatments),
        ("profile.json", PROFILE),
    ]);
    let basal = import.cohort.people[0].record.basal();
    for (k, u_h) in [(0, 1.0), (3, 1.0), (4, 1.5), (7, 1.5), (8, 1.0), (11, 1.0), (12, 2.0)] {
        let found = basal[k].expect("recorded");
        assert!((found - u_h).abs() < 1e-9, "step {k}: {found}, not {u_h}"); // rounding of sums
    }
}

#[test]
fn a_switch_may_shift_the_schedule_and_a_deleted_record_counts_for_nothing() {
    let profile = r#"[{"defaultProfile":"A","store":{"A":{"timezone":"UTC","basal":[
        {"time":"00:00","value":1},{"time":"10:00","value":3}]}}}]"#;
    // xDrip's way to write an offset; 08:00 UTC.
    let entries: String = (0..12)
        .map(|k| {
            format!("{{\"sgv\":100,\"dateString\":\"2024-03-01T09:{:02}:00.000+0100\"}}\n", 5 * k)
        })
        .collect();
    let entries = format!("{entries}{{\"sgv\":300,\"date\":1709280000000,\"isValid\":false}}\n");
    let treatments = r#"[
        {"eventType":"Profile Switch","created_at":"2024-03-01T08:15:00Z","profile":"A",
         "CircadianPercentageProfile":true,"percentage":200,"timeshift":2,"duration":15},
        {"eventType":"Temp Basal Start","created_at":"2024-03-01T08:40:00Z","absolute":0.5,
         "duration":30},
        {"eventType":"Temp Basal End","created_at":"2024-03-01T08:50:00Z"},
        {"eventType":"Correction Bolus","created_at":"2024-03-01T08:20:00Z","insulin":2,
         "isValid":false},
        {"eventType":"Correction Bolus","created_at":"2024-03-01T08:25:00Z","insulin":1}]"#;
    let import = read(&[
        ("entries.json", &entries),
        ("treatments.json", treatments),
        ("profile.json", profile),
    ]);
    let record = &import.cohort.people[0].record;
    assert_eq!((record.start().to_string().as_str(), record.len()), ("2024-03-01 08:00:00", 12));
    let rates: Vec<f64> = record.basal().iter().map(|rate| rate.expect("recorded")).collect();
    // 08:15 is read as 10:15: twice 3 U/h.
    assert_eq!(rates, [1.0, 1.0, 1.0, 6.0, 6.0, 6.0, 1.0, 1.0, 0.5, 0.5, 1.0, 1.0]);
    assert_eq!(record.bolus().iter().flatten().sum::<f64>(), 1.0);
    assert_eq!(record.cgm()[0], Some(100.0));
    assert!(notes(&import).contains("records that were deleted: left out"), "{}", notes(&import));
}

/// As AndroidAPS uploads them: carbohydrate over a time in ms, and switches to the rates of earlier hours.
#[test]
fn extended_carbohydrate_and_shifts_of_androidaps_are_read() {
    let profile = PROFILE.replace("\"value\":1}", "\"value\":1},{\"time\":\"07:00\",\"value\":3}");
    let entries: String = (0..36)
        .map(|k| format!("{{\"sgv\":100,\"date\":{}}}\n", 1_709_280_000_000_i64 + 300_000 * k))
        .collect();
    // From 08:00 UTC on; 2 h back at 08:30: the rate of 06:30, until 07:00 there is 09:00 here.
    let treatments = r#"[
        {"eventType":"Carb Correction","created_at":"2024-03-01T08:00:00Z","carbs":36,
         "duration":7200000},
        {"eventType":"Meal Bolus","created_at":"2024-03-01T10:30:00Z","carbs":20,"duration":0},
        {"eventType":"Profile Switch","created_at":"2024-03-01T08:30:00Z","profile":"A",
         "percentage":100,"timeshift":7200000,"duration":0}]"#;
    let import = read(&[
        ("entries.json", &entries),
        ("treatments.json", treatments),
        ("profile.json", &profile),
    ]);
    let record = &import.cohort.people[0].record;
    let carbs: Vec<f64> = record.carbs().iter().map(|grams| grams.unwrap_or(0.0)).collect();
    assert!(carbs[..24].iter().all(|grams| (grams - 1.5).abs() < 1e-9), "{carbs:?}");
    assert_eq!((carbs[24], carbs[30]), (0.0, 20.0));
    let basal: Vec<f64> = record.basal().iter().map(|rate| rate.expect("recorded")).collect();
    assert_eq!((basal[0], basal[5], basal[6], basal[11], basal[12]), (3.0, 3.0, 1.0, 1.0, 3.0));
}

#[test]
fn the_zone_is_that_of_the_latest_profile_in_any_order() {
    let document = |from: &str, zone: &str| {
        PROFILE
            .trim_matches(['[', ']'])
            .replace("2024-01-01", from)
            .replace("\"UTC\"", &format!("\"{zone}\""))
    };
    let documents =
        [document("2020-01-01", "America/New_York"), document("2024-01-01", "Europe/Madrid")];
    let entries = r#"[{"sgv":100,"dateString":"2024-03-01T00:55:00Z"},
                      {"sgv":110,"dateString":"2024-03-01T01:00:00Z"}]"#;
    for order in [[0, 1], [1, 0]] {
        let profile = format!("[{},{}]", documents[order[0]], documents[order[1]]);
        let import = read(&[("entries.json", entries), ("profile.json", &profile)]);
        let record = &import.cohort.people[0].record;
        assert_eq!(record.start().to_string(), "2024-03-01 01:55:00");
        assert!(notes(&import).contains("several time zones"), "{}", notes(&import));
    }
}

#[test]
fn broken_files_are_refused_with_their_place() {
    let entry = r#"{"type":"sgv","sgv":100,"date":1709280000000}"#;
    let good = format!("[{entry}]");
    let long = format!("[{{\"sgv\":\"{}\"}}]", "x".repeat(17 << 20));
    for (name, text, says) in [
        ("entries.json", "", "entries.json: no data row"),
        ("entries.json", "[]", "entries.json: no data row"),
        ("entries.json", "sgv,date\n", "entries.json: not a readable table: not JSON"),
        ("entries.json", "[{\"sgv\":100,", "record 1: EOF while parsing"),
        ("entries.json", &format!("[{entry},{{\"sgv\""), "record 2: EOF"),
        ("entries.json", "[{\"sgv\":100}]", "row 1, column date: '' is not a time"),
        (
            "entries.json",
            "[{\"sgv\":\"high\",\"date\":1709280000000}]",
            "entries.json, row 1, column sgv: 'high' is not a number",
        ),
        (
            "entries.json",
            "[{\"sgv\":\"=1+1\",\"date\":1709280000000}]",
            "column sgv: '=1+1' is not a number",
        ),
        ("entries.json", "[{\"sgv\":100,\"date\":1e300}]", "column date: '1e+300' is not an inst"),
        ("entries.json", "[{\"sgv\":-5,\"date\":1709280000000}]", "column sgv: -5 is outside"),
        ("entries.json", "[{\"sgv\":5000,\"date\":1709280000000}]", "sgv: 5000 is outside 0 to"),
        ("entries.json", "[{\"type\":\"mbg\",\"mbg\":5}]", "no sensor reading of anyone"),
        ("entries.json", "[1,2]", "record 1: invalid type: integer"),
        ("entries.json", &long, "record 1: an object longer than 16 MiB"),
        (
            "treatments.json",
            "[{\"insulin\":-1,\"created_at\":\"2024-03-01T08:00:00Z\"}]",
            "treatments.json, row 1, column insulin: -1 is outside 0 to 100 U",
        ),
        (
            "treatments.json",
            "[{\"insulin\":1,\"created_at\":\"yesterday\"}]",
            "row 1, column created_at: 'yesterday' is not an instant",
        ),
        (
            "treatments.json",
            "[{\"eventType\":\"Temp Basal\",\"duration\":30,\"created_at\":\"2024-03-01T08:00:00Z\"}]",
            "row 1, column absolute: '' is not U/h; the key (or percent) is missing",
        ),
        (
            "treatments.json",
            "[{\"carbs\":1,\"duration\":1e99,\"created_at\":\"2024-03-01T08:00:00Z\"}]",
            "column duration: '1e+99' is not milliseconds",
        ),
        (
            "treatments.json",
            "[{\"eventType\":\"Temp Basal\",\"absolute\":1,\"duration\":1e99,\
              \"created_at\":\"2024-03-01T08:00:00Z\"}]",
            "column duration: '1e+99' is not minutes",
        ),
        (
            "profile.json",
            "[{\"store\":{\"D\":{\"basal\":[{\"time\":\"25:00\",\"value\":1}]}}}]",
            "store.D.basal: '[{\\\"time\\\":\\\"25:00\\\",\\\"value\\\":1}]' is not rates whose time",
        ),
        (
            "profile.json",
            "[{\"store\":{\"D\":{\"basal\":[{\"time\":\"9223372036854775807:00\",\"value\":1}]}}}]",
            "is not rates whose time is HH:MM within a day",
        ),
        (
            "profile.json",
            "[{\"store\":{\"D\":{\"basal\":[{\"time\":\"01:-5\",\"value\":1}]}}}]",
            "is not rates whose time is HH:MM within a day",
        ),
        ("profile.json", "[{\"store\":{\"D\":{\"timezone\":\"Mars\"}}}]", "'Mars' is not the name"),
    ] {
        let mut files: Vec<(&str, &[u8])> =
            vec![("entries.json", good.as_bytes()), ("profile.json", PROFILE.as_bytes())];
        files.retain(|file| file.0 != name);
        files.push((name, text.as_bytes()));
        let message = refusal(FORMAT, &files);
        assert!(message.contains(says), "{}: {message}", text.get(..60).unwrap_or(text));
    }
    let message = refusal(FORMAT, &[("entries.json", good.as_bytes())]);
    assert!(message.contains("column utcOffset: '' is not minutes ahead of UTC"), "{message}");
    let far = b"[{\"sgv\":100,\"date\":1709280000000,\"utcOffset\":-1e10}]";
    let message = refusal(FORMAT, &[("entries.json", far)]);
    assert!(message.contains("' is not minutes ahead of UTC"), "{message}");
    let high = b"{\"sgv\":5.5,\"date\":1709280000000,\"utcOffset\":0}\n\
                 {\"sgv\":5.6,\"date\":1709280300000,\"utcOffset\":0}\n\
                 {\"sgv\":200,\"date\":1709280600000,\"utcOffset\":0}\n";
    let message = refusal(FORMAT, &[("entries.json", high)]);
    let says = "entries.json, row 3, column sgv: 3600 is outside 0 to 2000 mg/dL";
    assert!(message.contains(says), "{message}");
    let latin = b"[{\"sgv\":100,\"device\":\"caf\xE9\",\"date\":1709280000000}]";
    let message = refusal(FORMAT, &[("entries.json", latin)]);
    assert!(message.contains("save the file as UTF-8"), "{message}");
    let message = refusal(FORMAT, &[("entries.json", b"\xFF\xFE[\0")]);
    assert!(message.contains("UTF-16"), "{message}");
    let message = refusal(FORMAT, &[("other.txt", b"")]);
    assert!(message.contains("no file named entries*.json"), "{message}");
}
