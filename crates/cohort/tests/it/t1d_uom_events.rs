//! The T1D-UOM importer on a small made-up folder, with every number computed by hand.

use std::fs;
use std::path::Path;

use cohort::{Import, ImportFormat, Therapy, Totals, import};

fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().expect("inside a folder")).expect("writable");
    fs::write(path, text).expect("writable");
}

const GLUCOSE: &str = "bg_ts,value\n01/03/2024 08:01,7\n01/03/2024 08:06,7.5\n\
                       01/03/2024 08:06,7.6\n01/03/2024 08:07,9.9\n01/03/2024 08:13,8\n\
                       01/03/2024 08:20,10\n01/03/2024 08:26,11\n01/03/2024 08:30,12\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    write(at, "Glucose Data/UoMGlucose1.csv", GLUCOSE);
    write(
        at,
        "Insulin Data/Basal Data/UoMBasal1.csv",
        "\u{feff}basal_ts,basal_dose,insulin_kind,,\r\n01/03/2024 07:00,20,L,,\r\n\
         01/03/2024 08:03,1.2,R,,\r\n01/03/2024 08:03,0.6,R,,\r\n01/03/2024 08:12,2.4,R,,\r\n\
         01/03/2024 08:30,0,R,,\r\n,,,,\r\n",
    );
    write(
        at,
        "Insulin Data/Bolus Data/UoMBolus1.csv",
        "\u{feff}bolus_ts,bolus_dose\n01/03/2024 08:06,1.5\n01/03/2024 08:09,0.5\n\
         01/03/2024 08:21,0\n01/03/2024 09:00,3\n",
    );
    write(
        at,
        "Nutrition Data/UoMNutrition1.csv",
        "meal_ts,meal_type,meal_tag,carbs_g,prot_g\n01/03/2024 07:00,Breakfast,,10,\n\
         01/03/2024 08:14,Brunch,\"Fish, chips\",30,2\n01/03/2024 08:10,Brunch,,5,\n\
         01/03/2024 08:11,Drink,,,\n01/03/2024,Snack,,20,\n",
    );
    write(
        at,
        "Activity Data/UoMActivity1.csv",
        "activity_ts,activity_type,step_count,duration_s,start_time_offset_s\n\
         01/03/2024 08:00,WALKING,30,900,3600\n01/03/2024 08:00,RUNNING,60,900,3600\n",
    );
    // Asleep from 07:10:00 to 07:17:30 UTC, awake to 07:20:00; local time is an hour later.
    write(
        at,
        "Sleep Data/UoM1sleeptime.csv",
        "start_date_ts,duration_in_sec,start_time_offset_s,awake_s,sleep_levels_map.deep,,\
         sleep_levels_map_awake\n01/03/2024 07:10,450,3600,150,\
         \"[{\"\"startTimeInSeconds\"\":1709277000,\"\"endTimeInSeconds\"\":1709277450}]\",,\
         \"[{\"\"startTimeInSeconds\"\":1709277450,\"\"endTimeInSeconds\"\":1709277600}]\"\n",
    );
    write(at, "Sleep Data/UoMsleep1.csv", "whatever\n");
    folder
}

fn read(folder: &tempfile::TempDir) -> Import {
    import(ImportFormat::T1dUom, folder.path()).expect("a good folder")
}

fn close(found: &[Option<f64>], expected: &[Option<f64>]) {
    let near = |pair: (&Option<f64>, &Option<f64>)| match pair {
        (Some(a), Some(b)) => (a - b).abs() < 1e-12, // rounding of a few sums
        (a, b) => a == b,
    };
    assert!(
        found.len() == expected.len() && found.iter().zip(expected).all(near),
        "{found:?} is not {expected:?}"
    );
}

#[test]
fn events_are_laid_on_the_grid_and_every_amount_is_accounted_for() {
    let import = read(&folder());
    let record = &import.cohort.people[0].record;
    // Whole steps between the first and the last rate, within the readings: 08:05 to 08:30.
    assert_eq!(record.start().to_string(), "2024-03-01 08:05:00");
    // mmol/L x 18; the reading nearest to each step.
    close(record.cgm(), &[Some(135.0), None, Some(144.0), Some(180.0), Some(198.0)]);
    // 08:10 to 08:12 at 0.6 U/h, then 2.4 U/h: a mean of 1.68 U/h.
    close(record.basal(), &[Some(0.6), Some(1.68), Some(2.4), Some(2.4), Some(2.4)]);
    close(record.bolus(), &[Some(2.0), Some(0.0), Some(0.0), Some(0.0), Some(0.0)]);
    // Logged from 07:00 to 08:14; nothing is known after.
    close(record.carbs(), &[Some(0.0), Some(35.0), None, None, None]);
    // 90 steps in 15 min from 08:00.
    close(record.steps(), &[Some(30.0), Some(30.0), None, None, None]);
    // Awake with the watch on; asleep; half asleep; no watch.
    close(record.sleep_efficiency(), &[Some(0.0), Some(1.0), Some(0.5), None, None]);

    let totals: Vec<(&str, f64, f64, f64)> = import.report.people[0]
        .totals
        .iter()
        .flatten()
        .map(|t: &Totals| (t.column.as_str(), t.source, t.record, t.left_out))
        .collect();
    // 9 min at 0.6 U/h and 18 min at 2.4 U/h, and the injection.
    for (found, expected) in totals.iter().zip([
        ("basal_u_h", 20.81, 0.79, 20.02),
        ("bolus_u", 5.0, 2.0, 3.0),
        ("carbs_g", 65.0, 35.0, 30.0),
    ]) {
        assert_eq!(found.0, expected.0);
        close(
            &[Some(found.1), Some(found.2), Some(found.3)],
            &[Some(expected.1), Some(expected.2), Some(expected.3)],
        );
    }
    assert_eq!(totals.len(), 3);
}

#[test]
fn every_liberty_is_noted_with_its_place() {
    let import = read(&folder());
    let notes: Vec<String> = import.report.notes.iter().map(ToString::to_string).collect();
    for says in [
        "UoMBasal1.csv, row 2, column basal_dose: long-acting injections, which no basal rate \
         describes: left out (1x)",
        "UoMBasal1.csv, row 4, column basal_dose: rates at one time: the last one of the file \
         holds (1x)",
        "UoMBasal1.csv, column basal_dose: 0.02 U of basal outside whole steps of the span: left \
         out (1x)",
        "UoMBolus1.csv, row 3, column bolus_dose: amounts in a step that already has one: summed \
         (1x)",
        "UoMBolus1.csv, row 5, column bolus_dose: amounts outside the span of glucose and \
         insulin: left out (1x)",
        "UoMNutrition1.csv, row 6, column meal_ts: values on a date without a time of day: left \
         out, since the step is unknown (1x)",
        "UoMNutrition1.csv, row 5, column carbs_g: rows without an amount: left out (1x)",
        "UoMNutrition1.csv, row 4, column meal_ts: rows earlier than the row above: sorted (1x)",
        "UoMGlucose1.csv, column value: readings beside a nearer or earlier one of the step: \
         left out (2x)",
        "UoMGlucose1.csv, column value: readings at the time of another but with another value \
         (1x)",
        "Sleep Data/UoMsleep1.csv: five-minute heart rate whose times are not aligned with the \
         rest: refused (1x)",
    ] {
        assert!(notes.iter().any(|note| note.ends_with(says)), "{says}\nis not in {notes:#?}");
    }
}

#[test]
fn the_report_is_flat_json() {
    let report = serde_json::to_value(read(&folder()).report).expect("the report is JSON");
    assert_eq!(report["format"], "t1d-uom");
    let person = &report["people"][0];
    assert_eq!(
        person["line"],
        "1: 0 days, 45.5 + 115.2 U/day, 5040 g/day, mean 164 mg/dL, CGM 80 %, heart rate 0 %"
    );
    assert_eq!(person["balance"]["cgm_share"], 0.8);
    assert_eq!(person["findings"][0]["what"], "mean insulin a day");
    let note = serde_json::json!({
        "person": "1",
        "file": "Insulin Data/Bolus Data/UoMBolus1.csv",
        "row": 5,
        "column": "bolus_dose",
        "what": "amounts outside the span of glucose and insulin: left out",
        "count": 1,
    });
    assert!(report["notes"].as_array().is_some_and(|notes| notes.contains(&note)), "{report:#}");
}

#[test]
fn injections_alone_are_mdi_without_a_basal_rate() {
    let folder = folder();
    write(
        folder.path(),
        "Insulin Data/Basal Data/UoMBasal1.csv",
        "basal_ts,basal_dose,insulin_kind\n01/03/2024 07:00,20,L\n",
    );
    let import = read(&folder);
    let person = &import.cohort.people[0];
    assert_eq!(person.therapy, Therapy::Mdi);
    assert!(person.record.basal().iter().all(Option::is_none));
    // Where insulin is recorded, boluses from 08:06 on define the span.
    assert_eq!(person.record.start().to_string(), "2024-03-01 08:05:00");
    assert_eq!(person.record.bolus()[0], Some(2.0));
    let totals = import.report.people[0].totals.as_ref().expect("an importer's account");
    let basal = &totals[0];
    assert_eq!((basal.source, basal.record, basal.left_out), (20.0, 0.0, 20.0));
}

#[test]
fn a_silent_pump_is_missing_and_not_zero() {
    let folder = folder();
    let mut glucose = String::from("bg_ts,value\n");
    for hour in 0..48 {
        let (day, hour) = (1 + hour / 24, hour % 24);
        glucose += &format!("{day:02}/03/2024 {hour:02}:00,7\n");
    }
    write(folder.path(), "Glucose Data/UoMGlucose1.csv", &glucose);
    write(
        folder.path(),
        "Insulin Data/Basal Data/UoMBasal1.csv",
        "basal_ts,basal_dose,insulin_kind\n01/03/2024 00:00,1,R\n02/03/2024 06:00,1,R\n",
    );
    let import = read(&folder);
    let record = &import.cohort.people[0].record;
    assert_eq!(record.len(), 30 * 12);
    assert!(record.basal()[..288].iter().all(|rate| *rate == Some(1.0)));
    assert!(record.basal()[288..].iter().chain(&record.bolus()[288..]).all(Option::is_none));
    let notes: Vec<String> = import.report.notes.iter().map(ToString::to_string).collect();
    assert!(notes.iter().any(|note| note.contains("more than 24 h after a rate")), "{notes:#?}");
}

#[test]
fn dates_without_a_time_are_one_note_whatever_the_amounts() {
    let folder = folder();
    write(
        folder.path(),
        "Nutrition Data/UoMNutrition1.csv",
        "meal_ts,carbs_g\n01/03/2024 08:14,30\n01/03/2024,20\n02/03/2024,21\n03/03/2024,22\n",
    );
    let import = read(&folder);
    let notes: Vec<String> = import.report.notes.iter().map(ToString::to_string).collect();
    let of_dates: Vec<&String> =
        notes.iter().filter(|note| note.contains("without a time of day")).collect();
    assert_eq!(of_dates.len(), 1, "{of_dates:#?}");
    assert!(of_dates[0].ends_with("(3x)"), "{of_dates:#?}");
}

#[test]
fn a_copy_of_a_file_is_not_passed_over() {
    let folder = folder();
    write(folder.path(), "Glucose Data/UoMGlucose1 (1).csv", GLUCOSE);
    let error = import(ImportFormat::T1dUom, folder.path()).expect_err("a copy").to_string();
    assert!(error.starts_with("Glucose Data/UoMGlucose1 (1).csv: not in the layout"), "{error}");
}

#[test]
fn broken_events_are_errors_with_their_place() {
    for (file, text, says) in [
        (
            "Glucose Data/UoMGlucose1.csv",
            "bg_ts,value\n01/03/2024 08:00,126\n",
            "looks like mg/dL, not mmol/L",
        ),
        (
            "Glucose Data/UoMGlucose1.csv",
            "bg_ts,value\n03/31/2024 08:00,7\n",
            "row 2, column bg_ts: '03/31/2024 08:00' is not a time like 31/12/2023 08:05 (day first)",
        ),
        ("Glucose Data/UoMGlucose1.csv", "bg_ts,value\n,7\n", "column bg_ts: '' is not a time"),
        (
            "Glucose Data/UoMGlucose1.csv",
            "bg_ts,value\n01/03/1024 08:00,7\n",
            "row 2, column bg_ts: '01/03/1024 08:00' is not a time like 31/12/2023 08:05",
        ),
        (
            "Glucose Data/UoMGlucose1.csv",
            "bg_ts,value\n01/03/2024 08:00,-7\n",
            "column value: -126 is outside 0 to 2000 mg/dL",
        ),
        (
            "Glucose Data/UoMGlucose1.csv",
            "bg_ts,value\n01/03/2024 08:00,.5\n01/03/2024 08:15,.5\n01/03/2024 08:30,.5\n",
            "person '1': the median glucose would be 9 mg/dL, which nobody has; check the unit",
        ),
        (
            "Glucose Data/UoMGlucose1.csv",
            "bg_ts,glucose\n01/03/2024 08:00,7\n",
            "no column 'value'; found bg_ts, glucose",
        ),
        ("Glucose Data/UoMGlucose1.csv", "", "Glucose Data/UoMGlucose1.csv: no data row"),
        (
            "Glucose Data/UoMGlucose1.csv",
            "bg_ts,value\n01/03/2020 08:00,7\n",
            "glucose of person '1' ends at 2020-03-01 08:05:00 before insulin begins",
        ),
        (
            "Insulin Data/Basal Data/UoMBasal1.csv",
            "basal_ts,basal_dose,insulin_kind\n01/03/2024 08:00,1,X\n",
            "column insulin_kind: 'X' is not R (a rate) or L",
        ),
        (
            "Insulin Data/Basal Data/UoMBasal1.csv",
            "basal_ts,basal_dose,insulin_kind\n01/03/2024,1,R\n",
            "'01/03/2024' is not a time like 31/12/2023 08:05; the hour is missing",
        ),
        (
            "Insulin Data/Bolus Data/UoMBolus1.csv",
            "bolus_ts,bolus_dose\n01/03/2024 08:00,-1\n",
            "column bolus_dose: -1 is outside 0 to 100 U",
        ),
        (
            "Insulin Data/Bolus Data/UoMBolus1.csv",
            "bolus_ts,bolus_dose\n01/03/2024 08:00,two\n",
            "column bolus_dose: 'two' is not a number",
        ),
        (
            "Sleep Data/UoM1sleeptime.csv",
            "start_date_ts,duration_in_sec,start_time_offset_s,awake_s,sleep_levels_map_deep\n01/03/2024 07:10,450,3600,0,[{]\n",
            "column sleep_levels_map_deep: '[{]' is not a JSON list",
        ),
        (
            "Insulin Data/Bolus Data/UoMBolus1.csv",
            "bolus_ts,bolus_dose\n01/03/2024 08:06,60\n01/03/2024 08:09,60\n",
            "UoMBolus1.csv, row 3, column bolus_dose: 120 is outside 0 to 100 U",
        ),
        (
            "Activity Data/UoMActivity1.csv",
            "activity_ts,step_count,duration_s,start_time_offset_s\n01/03/2024 08:00,20000,900,3600\n",
            "UoMActivity1.csv, row 2, column step_count: 6666.6",
        ),
        (
            "Activity Data/UoMActivity1.csv",
            "activity_ts,step_count,duration_s,start_time_offset_s\n01/03/2024 08:00,-5,900,3600\n",
            "row 2, column step_count: '-5' is not a count of steps",
        ),
        (
            "Activity Data/UoMActivity1.csv",
            "activity_ts,step_count,duration_s,start_time_offset_s\n01/03/2024 08:00,5,9e6,3600\n",
            "row 2, column duration_s: '9e6' is not seconds of an interval",
        ),
        // The last second that the library of times knows.
        (
            "Sleep Data/UoM1sleeptime.csv",
            "start_date_ts,duration_in_sec,start_time_offset_s,awake_s,sleep_levels_map_deep\n\
             01/03/2024 07:10,450,3600,0,\"[{\"\"startTimeInSeconds\"\":8210266876799,\
             \"\"endTimeInSeconds\"\":8210266876799}]\"\n",
            "is not a JSON list of startTimeInSeconds and endTimeInSeconds",
        ),
        (
            "Sleep Data/UoM1sleeptime.csv",
            "start_date_ts,duration_in_sec,start_time_offset_s,awake_s\n01/03/2024 07:10,9e6,3600,0\n",
            "column duration_in_sec: '9e6' is not seconds of one sleep",
        ),
    ] {
        let folder = folder();
        write(folder.path(), file, text);
        let error = import(ImportFormat::T1dUom, folder.path()).expect_err(says).to_string();
        assert!(error.contains(says), "wanted: {says}\n   got: {error}");
    }
}
