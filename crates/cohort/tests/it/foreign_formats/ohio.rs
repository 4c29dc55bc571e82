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
