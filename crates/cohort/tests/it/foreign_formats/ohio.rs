//! OhioT1DM.

use cohort::{Channel, ImportFormat};

use super::{check, refusal};

const FORMAT: ImportFormat = ImportFormat::Ohio;

#[test]
fn the_morning_is_read() {
    let channels = [
        Channel::Cgm,
        Channel::Basal,
        Channel::Bolus,
        Channel::Carbs,
        Channel::HeartRate,
        Channel::Steps,
        Channel::SleepEfficiency,
    ];
    let import = check(FORMAT, &channels);
    // The weight of 99 is no weight; both files are one person.
    assert_eq!(import.cohort.people[0].weight, None);
}

/// A temporary rate within another ends it, and the programme that was changed meanwhile goes on.
#[test]
fn the_programme_goes_on_after_temporary_rates_that_overlap() {
    let readings: String = (0..36)
        .map(|k| {
            let (hour, minute) = (10 + k / 12, 5 * (k % 12));
            format!("<event ts=\"07-12-2021 {hour}:{minute:02}:00\" value=\"100\"/>")
        })
        .collect();
    let temporary = |from: &str, to: &str, u_h: f64| {
        format!(
            "<event ts_begin=\"07-12-2021 {from}:00\" ts_end=\"07-12-2021 {to}:00\" value=\"{u_h}\"/>"
        )
    };
    let text = format!(
        "<patient id=\"559\"><glucose_level>{readings}</glucose_level><basal>\
         <event ts=\"07-12-2021 09:00:00\" value=\"1.0\"/>\
         <event ts=\"07-12-2021 11:30:00\" value=\"1.5\"/>\
         <event ts=\"07-12-2021 13:00:00\" value=\"1.5\"/></basal><temp_basal>{}{}</temp_basal></patient>",
        temporary("10:00", "12:00", 0.2),
        temporary("10:30", "11:00", 0.4)
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("559-ws-training.xml"), text).expect("writable");
    let import = cohort::import(FORMAT, folder.path()).expect("a good file");
    let basal = import.cohort.people[0].record.basal();
    let rates = [0, 6, 12, 17, 18, 30].map(|step| basal[step].expect("recorded"));
    assert_eq!(rates, [0.2, 0.4, 1.0, 1.0, 1.5, 1.5]);
}

#[test]
fn broken_files_are_refused_with_their_place() {
    let event = |event: &str| {
        format!("<patient id=\"559\"><glucose_level>{event}</glucose_level></patient>")
    };
    for (text, says) in [
        (String::new(), "559.xml: no data row"),
        ("a,b\n1,2\n".into(), "not in the layout of ohio: no element <patient"),
        ("<html><body/></html>".into(), "no element <patient"),
        ("<patient id=\"../x\"/>".into(), "column patient id: '../x' is not a patient's"),
        ("<patient id=\"559\"><glucose_level>".into(), "cut off within <patient><glucose_level>"),
        ("<patient id=\"559\"><glucose_level><event ts=\"".into(), "not a readable table: at byte"),
        ("<patient id=\"559\"></glucose_level></patient>".into(), "not a readable table: at byte"),
        (
            event("<event ts=\"07-12-2021 01:17:00\" value=\"high\"/>"),
            "559.xml, row 1, column glucose_level value: 'high' is not a number",
        ),
        (
            event("<event ts=\"12-31-2021 01:17:00\" value=\"100\"/>"),
            "row 1, column glucose_level ts: '12-31-2021 01:17:00' is not a time",
        ),
        (event("<event ts=\"07-12-2021 01:17:00\"/>"), "glucose_level value: '' is not a number"),
        (event("<event ts=\"07-12-2021 01:17:00\" value=\"5.5\"/>"), "looks like mmol/L"),
        (event("<event ts=\"07-12-2021 01:17:00\" value=\"-1\"/>"), "value: -1 is outside 0 to"),
        (event(""), "no sensor reading of anyone"),
        (
            event("").replace(
                "</patient>",
                "<bolus><event ts_begin=\"07-12-2021 02:00:00\" ts_end=\"07-12-2021 01:00:00\" \
                 dose=\"1\"/></bolus></patient>",
            ),
            "row 1, column bolus dose: '-3600 s' is not a duration",
        ),
    ] {
        let message = refusal(FORMAT, &[("559.xml", text.as_bytes())]);
        assert!(message.contains(says), "{text}: {message}");
    }
    let latin = refusal(FORMAT, &[("559.xml", b"<patient\nid=\"\xE9\"/>")]);
    assert!(latin.contains("559.xml, row 2: not UTF-8"), "{latin}");
}
