//! Tidepool.

use std::path::Path;

use cohort::{Channel, ImportFormat, TableOptions, import, import_with};

use super::{check, check_at, fixture, notes};

const CHANNELS: [Channel; 5] =
    [Channel::Cgm, Channel::Basal, Channel::Bolus, Channel::Carbs, Channel::SetChange];

#[test]
fn the_morning_is_read() {
    let import = check(ImportFormat::Tidepool, &CHANNELS);
    let notes = notes(&import);
    for says in [
        "p1.json, column basal_u_h: rates that a later one ends (1x)",
        "column formulation: injections that are not rapid insulin: left out (1x)",
        "data with an id that came before: left out (2x)",
    ] {
        assert!(notes.contains(says), "{says} is not in\n{notes}");
    }
}

#[test]
fn what_the_site_exports_is_the_same_morning() {
    // Its food has neither the local time nor an offset.
    let madrid = TableOptions { zone: Some("Europe/Madrid".into()), ..Default::default() };
    for (name, says) in [
        ("tidepool-site", "injections without dose and insulin, which Tidepool's site"),
        (
            "tidepool-xlsx",
            "p1.xlsx, sheet Upload, row 3, column Id: data with an id that came before: left out (2x)",
        ),
    ] {
        let source = fixture(name);
        let imported = check_at(ImportFormat::Tidepool, &source, &madrid, &CHANNELS);
        assert!(notes(&imported).contains(says), "{says} is not in\n{}", notes(&imported));
        let inferred = imported.report.inferences.iter().flatten();
        let minutes = inferred.filter(|one| one.conclusion == "durations in minutes").count();
        assert_eq!(minutes, usize::from(name == "tidepool-site"), "{name}");
    }
    let message = import(ImportFormat::Tidepool, &fixture("tidepool-xlsx")).expect_err("no zone");
    let says = "p1.xlsx, sheet Food, row 2, column Device Time: '' is not a local time";
    assert!(message.to_string().starts_with(says), "{message}");
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
fn insulin_that_is_not_rapid_is_in_the_totals() {
    let text = r#"[
        {"type":"cbg","units":"mg/dL","value":100,"deviceTime":"2024-03-01T08:00:00"},
        {"type":"insulin","formulation":{"simple":{"actingType":"long"}},
         "dose":{"total":12,"units":"Units"},"deviceTime":"2024-03-01T08:00:00"}]"#;
    let import = read(text).expect("good data");
    let totals = import.report.people[0].totals.as_ref().expect("totals");
    let found: Vec<_> =
        totals.iter().map(|t| (t.column.as_str(), t.source, t.record, t.left_out)).collect();
    assert_eq!(found, [("basal_u_h", 12.0, 0.0, 12.0)]);
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
            "column duration: '-5' is not a duration from 0 to 10 days",
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

/// The message that refuses the bytes of a workbook.
fn refused(bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("p1.xlsx"), bytes).expect("writable");
    let madrid = TableOptions { zone: Some("Europe/Madrid".into()), ..Default::default() };
    import_with(ImportFormat::Tidepool, &[folder.path().to_owned()], &madrid)
        .map(|_| ())
        .expect_err("refused")
        .to_string()
}

/// The exported workbook with other bytes in place of the part `name`; `None` leaves it out.
fn with_part(name: &str, content: Option<&[u8]>) -> Vec<u8> {
    let file = std::fs::File::open(fixture("tidepool-xlsx/p1.xlsx")).expect("a fixture");
    let mut old = zip::ZipArchive::new(file).expect("an archive");
    let mut new = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for i in 0..old.len() {
        let part = old.by_index(i).expect("a part");
        let is_it = Path::new(&*part.name().expect("a name")) == Path::new(name);
        if !is_it {
            new.raw_copy_file(part).expect("writable");
        }
    }
    if let Some(content) = content {
        let options = zip::write::SimpleFileOptions::default();
        new.start_file(name, options).expect("writable");
        std::io::Write::write_all(&mut new, content).expect("writable");
    }
    new.finish().expect("writable").into_inner()
}

#[test]
fn damaged_workbooks_are_refused() {
    let good = std::fs::read(fixture("tidepool-xlsx/p1.xlsx")).expect("a fixture");
    let sheet = "xl/worksheets/sheet9.xml";
    let row = |cells: &str| {
        format!("<worksheet><sheetData><row r=\"1\">{cells}</row></sheetData></worksheet>")
    };
    let far = row("<c r=\"XFD1\" t=\"str\"><v>a</v></c>");
    let mut flipped = good.clone();
    flipped[2000] ^= 0x55;
    let huge = row(&format!("<c t=\"str\"><v>{}</v></c>", "x".repeat(2 << 20)));
    let long = row(&format!("<c t=\"str\"><v>{}</v></c>", "x".repeat(200_000)));
    let upside_down = "<worksheet><sheetData><row r=\"5\"><c><v>1</v></c></row><row r=\"2\"><c>\
                       <v>1</v></c></row></sheetData></worksheet>";
    for (bytes, says) in [
        (good[..good.len() / 2].to_vec(), "not an Excel workbook, or cut off"),
        (good[..100].to_vec(), "not an Excel workbook, or cut off"),
        (flipped, "cannot be unpacked"),
        (with_part("xl/workbook.xml", None), "no sheet has a column"),
        (with_part(sheet, Some(b"<worksheet><sheetData><row")), "sheet CGM"),
        (with_part(sheet, Some(b"")), "sheet CGM"),
        (with_part(sheet, Some(b"<worksheet><!-- x --><sheetData/>")), "no spreadsheet program"),
        (with_part(sheet, Some(far.as_bytes())), "more than 4096 columns"),
        (with_part(sheet, Some(huge.as_bytes())), "no spreadsheet program"),
        (with_part(sheet, Some(long.as_bytes())), "row 1: a cell of more than 32,767 letters"),
        (with_part(sheet, Some(upside_down.as_bytes())), "rows are not in their order"),
    ] {
        let message = refused(&bytes);
        assert!(message.contains(says) && message.starts_with("p1.xlsx"), "{says}: {message}");
    }
}

#[test]
fn what_unpacks_to_too_much_is_refused_before_it_is_held() {
    // Some 70 kB that unpack to 65 MiB of shared texts.
    let bomb = vec![b' '; 65 << 20];
    let packed = with_part("xl/sharedStrings.xml", Some(&bomb));
    assert!(packed.len() < 200_000, "{}", packed.len());
    let message = refused(&packed);
    assert!(message.contains("'xl/sharedStrings.xml' unpacks to too much"), "{message}");
    let mut parts = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for i in 0..5000 {
        let options = zip::write::SimpleFileOptions::default();
        parts.start_file(format!("xl/{i}"), options).expect("writable");
    }
    let message = refused(&parts.finish().expect("writable").into_inner());
    assert!(message.contains("more than 4096 parts"), "{message}");
}

#[test]
fn an_interrupted_export_is_said_to_be_incomplete() {
    let workbook = {
        let file = std::fs::File::open(fixture("tidepool-xlsx/p1.xlsx")).expect("a fixture");
        let mut archive = zip::ZipArchive::new(file).expect("an archive");
        let part = archive.by_name("xl/workbook.xml").expect("a part");
        std::io::read_to_string(part).expect("text")
    };
    let shown = workbook.replace("veryHidden", "visible");
    assert_ne!(shown, workbook);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bytes = with_part("xl/workbook.xml", Some(shown.as_bytes()));
    std::fs::write(folder.path().join("p1.xlsx"), bytes).expect("writable");
    let madrid = TableOptions { zone: Some("Europe/Madrid".into()), ..Default::default() };
    let source = [folder.path().to_owned()];
    let imported = import_with(ImportFormat::Tidepool, &source, &madrid).expect("readable");
    let says = "p1.xlsx, sheet EXPORT ERROR: the export says that it is not complete";
    assert!(notes(&imported).contains(says), "{}", notes(&imported));
    let json = format!(
        "{},{{\"exportError\":\"x\"}}]",
        r#"[{"type":"cbg","units":"mg/dL","value":100,"deviceTime":"2024-03-01T08:00:00"}"#
    );
    let imported = read(&json).expect("readable");
    assert!(notes(&imported).contains("not complete"), "{}", notes(&imported));
    // The same person in both forms.
    std::fs::write(folder.path().join("p1.json"), json).expect("writable");
    let message = import(ImportFormat::Tidepool, folder.path()).expect_err("refused").to_string();
    assert!(message.contains("'p1.json' is of the same person"), "{message}");
}
