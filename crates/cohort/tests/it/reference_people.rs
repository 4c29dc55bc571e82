//! The importers on the real people of the reference data, judged person by person.

use std::path::Path;

use cohort::{
    Channel, Import, ImportFormat, MassBalance, MissingDoses, RecordsFormat, StraightLines,
    Therapy, WindowRule, import, insulin_u_day, read_folder, split_by_time, windows, write_folder,
};
use physiology::BeatsPerMinute;

fn read(format: ImportFormat, path: &Path) -> Import {
    let read = import(format, path).expect("the reference data import");
    for person in &read.report.people {
        for totals in person.totals.iter().flatten() {
            assert!(totals.closes(), "{}: {totals:?}", person.line);
        }
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    for format in [RecordsFormat::Csv, RecordsFormat::Parquet] {
        let folder = folder.path().join(format!("{format:?}"));
        write_folder(&read.cohort, &folder, format).expect("an imported cohort can be written");
        let again = read_folder(&folder).expect("a written cohort can be read");
        assert!(again == read.cohort, "every value is read back as it was imported");
    }
    serde_json::to_string(&read.report).expect("the report is JSON");
    read
}

fn balance<'a>(import: &'a Import, id: &str) -> &'a MassBalance {
    let (index, _) = import.cohort.find(id).expect("the person is there");
    &import.report.people[index].balance
}

/// How often something was noted for a person; 0 if it was not.
fn noted(import: &Import, id: &str, what: &str) -> usize {
    let of = import.report.notes.iter().filter(|note| note.person.as_deref() == Some(id));
    of.filter(|note| note.what.contains(what)).map(|note| note.count).sum()
}

/// The mass balance of every real person, one line each. Computed once by an independent script
/// (Python, `csv` module: sums of the columns over the span, times the unit) to the printed digits.
fn check(import: &Import, expected: &[&str]) {
    let lines: Vec<&str> = import.report.lines().collect();
    assert_eq!(lines, expected);
}

#[test]
fn hupa_ucm() {
    let Some(path) = reference_data::find("hupa_ucm", "hupa_ucm") else { return };
    let started = std::time::Instant::now();
    let import = read(ImportFormat::HupaUcm, &path);
    // 0.1 s on two cores; the bound allows for a slow machine, not for a quadratic reader.
    assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
    check(
        &import,
        &[
            "HUPA0002P: 11 days, 25.4 + 21.1 U/day, 58 g/day, mean 113 mg/dL, CGM 100 %, heart rate 100 %",
            "HUPA0003P: 13 days, 15.7 + 20.5 U/day, 332 g/day, mean 143 mg/dL, CGM 100 %, heart rate 100 %",
            "HUPA0004P: 11 days, 21.1 + 43.0 U/day, 183 g/day, mean 180 mg/dL, CGM 100 %, heart rate 100 %",
            "HUPA0005P: 13 days, 19.1 + 7.5 U/day, 66 g/day, mean 148 mg/dL, CGM 100 %, heart rate 100 %",
            "HUPA0006P: 8 days, 21.7 + 28.5 U/day, 282 g/day, mean 165 mg/dL, CGM 100 %, heart rate 100 %",
            "HUPA0009P: 13 days, 25.7 + 9.7 U/day, 38 g/day, mean 194 mg/dL, CGM 100 %, heart rate 100 %",
            "HUPA0016P: 13 days, 19.7 + 20.7 U/day, 248 g/day, mean 150 mg/dL, CGM 100 %, heart rate 100 %",
            "HUPA0019P: 13 days, 18.3 + ? U/day, ? g/day, mean 163 mg/dL, CGM 100 %, heart rate 100 %",
        ],
    );
    for person in &import.report.people {
        assert_eq!(person.findings, [], "{}", person.line);
        assert_eq!(person.therapy.as_deref(), Some(Therapy::OpenLoopPump.name()));
    }
    // The sensor reads every 15 min: two of three values lie on a line, or more where gaps were
    // filled. One person's whole trace was drawn.
    for person in &import.cohort.people {
        let share = StraightLines::find(person.record.cgm()).share;
        let (low, high) = if person.id == "HUPA0009P" { (0.97, 1.0) } else { (0.60, 0.72) };
        assert!((low..high).contains(&share), "{}: {share}", person.id);
    }
    let every_15_min =
        |inference: &&cohort::Inference| inference.conclusion.starts_with("a reading every 15 min");
    assert_eq!(import.report.inferences.iter().flatten().filter(every_15_min).count(), 7);
    assert_eq!(noted(&import, "HUPA0002P", "exactly 40 mg/dL"), 185);
    assert_eq!(noted(&import, "HUPA0019P", "entries without an amount"), 50 + 53);
    let (_, flags) = import.cohort.find("HUPA0019P").expect("the person is there");
    assert!(flags.record.bolus().iter().chain(flags.record.carbs()).all(Option::is_none));
    let rest = flags.resting_heart_rate().expect("heart rate is there");
    assert!((50.0..85.0).contains(&rest.0), "{rest:?}");
}

#[test]
fn t1d_uom() {
    let Some(path) = reference_data::find("t1d_uom", "t1d_uom") else { return };
    let import = read(ImportFormat::T1dUom, &path);
    check(
        &import,
        &[
            "2301: 69 days, 18.7 + 11.7 U/day, 117 g/day, mean 147 mg/dL, CGM 99 %, heart rate 0 %",
            "2309: 86 days, 19.3 + 10.5 U/day, 92 g/day, mean 177 mg/dL, CGM 84 %, heart rate 0 %",
            "2310: 63 days, 21.4 + 20.0 U/day, ? g/day, mean 129 mg/dL, CGM 98 %, heart rate 0 %",
        ],
    );
    let therapies = import.report.people.iter().map(|person| person.therapy.as_deref());
    let expected = [Therapy::Aid, Therapy::OpenLoopPump, Therapy::OpenLoopPump];
    assert!(therapies.eq(expected.map(|therapy| Some(therapy.name()))));
    for person in &import.report.people {
        let means = person.findings.iter().filter(|finding| finding.date.is_none());
        assert_eq!(means.count(), 0, "{:?}", person.findings);
        assert!(insulin_u_day(balance(&import, &person.balance.person)).is_some());
    }
    // Counted in the files: rows at the time of the row above; rows with a date alone.
    assert_eq!(noted(&import, "2301", "rates at one time"), 20);
    assert_eq!(noted(&import, "2309", "without a time of day"), 4);
    assert_eq!(noted(&import, "2310", "no nutrition file"), 1);
    // Two streams two or three minutes apart, each stored more than once.
    assert!(noted(&import, "2301", "interleaved or repeated streams") > 15_000);
    assert_eq!(noted(&import, "2309", "interleaved or repeated streams"), 0);

    for (id, asleep) in [("2301", 6.0..10.0), ("2309", 5.0..9.5)] {
        let (_, person) = import.cohort.find(id).expect("the person is there");
        // Sleep lies at night: local time is UTC plus the offset, at most an hour here.
        let hours = |from: u8, to: u8| -> f64 {
            let record = &person.record;
            let of_day = (0..record.len()).filter(|&k| (from..to).contains(&record.hour(k)));
            let values: Vec<f64> = of_day.filter_map(|k| record.sleep_efficiency()[k]).collect();
            values.iter().sum::<f64>() / values.len() as f64
        };
        assert!(hours(2, 5) > 0.6 && hours(13, 18) < 0.1, "{} {}", hours(2, 5), hours(13, 18));
        let nightly = 24.0 * hours(0, 24);
        assert!(asleep.contains(&nightly), "{id}: {nightly} h");
    }
    // Nobody is both trained on and held out.
    let (index, person) = import.cohort.find("2301").expect("the person is there");
    let split = split_by_time(&person.record, cohort::TRAINING_DAYS);
    let train = windows(index, &person.record, split.train, &WindowRule::TRAINING);
    assert!(train.expect("a good rule").len() > 300);
}

#[test]
fn t1dsim_keeps_every_number_of_the_file() {
    let Some(path) = reference_data::find("t1dsim_ai/example_subjectX.csv", "t1dsim") else {
        return;
    };
    let import = read(ImportFormat::T1dSim, &path);
    check(
        &import,
        &[
            "example_subjectX: 1 days, 30.2 + 0.0 U/day, 70 g/day, mean 133 mg/dL, CGM 100 %, heart rate 100 %",
        ],
    );
    let person = &import.cohort.people[0];
    assert_eq!(person.heart_rate_baseline, Some(BeatsPerMinute(0.0)));

    // Read here without the crate's reader: position of the name in the header, text to f64.
    let text = std::fs::read_to_string(path).expect("readable");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    let column = |name: &str| -> Vec<f64> {
        let at = header.iter().position(|column| *column == name).expect("the column is there");
        rows.iter().map(|row| row[at]).collect()
    };
    let inputs = person.inputs(0..rows.len(), MissingDoses::Error).expect("complete");
    let insulin: Vec<f64> = inputs.iter().map(|input| input.insulin().0).collect();
    let carbs: Vec<f64> = inputs.iter().map(|input| input.carbs.0).collect();
    let hours: Vec<f64> = inputs.iter().map(|input| f64::from(input.context.hour)).collect();
    let weekend: Vec<f64> =
        inputs.iter().map(|input| f64::from(u8::from(input.context.weekend))).collect();
    let heart_rate: Vec<f64> =
        inputs.iter().filter_map(|i| i.context.heart_rate_over_baseline.map(|b| b.0)).collect();
    let sleep: Vec<f64> = inputs.iter().filter_map(|i| i.context.sleep_efficiency).collect();
    let cgm: Vec<f64> = person.record.cgm().iter().copied().flatten().collect();
    // Bit for bit: heart rates carry ten digits of an f32, insulin rates rounded sums.
    assert_eq!(insulin, column("input_insulin_ODEPop"));
    assert_eq!(carbs, column("input_meal_carbs_ODEPop"));
    assert_eq!(hours, column("hour_of_day"));
    assert_eq!(weekend, column("feat_is_weekend"));
    assert_eq!(heart_rate, column("heart_rate_WRTbaseline"));
    assert_eq!(sleep, column("sleep_efficiency"));
    assert_eq!(cgm, column("cgm"));
    assert!(person.record.channel(Channel::Steps).iter().all(Option::is_none));
}

#[test]
fn folders_of_the_wrong_study_are_refused() {
    let Some(hupa) = reference_data::find("hupa_ucm", "wrong study") else { return };
    let Some(uom) = reference_data::find("t1d_uom", "wrong study") else { return };
    let Some(example) = reference_data::find("t1dsim_ai/example_subjectX.csv", "wrong study")
    else {
        return;
    };
    let hupa_file = hupa.join("HUPA0002P.csv");
    for (format, path, says) in [
        (ImportFormat::T1dUom, &hupa, "not in the layout of t1d-uom: no folder 'Glucose Data'"),
        (ImportFormat::HupaUcm, &uom, "not in the layout of hupa-ucm: no file named HUPA*.csv"),
        (ImportFormat::T1dSim, &hupa, "no file named example_subject*.csv"),
        (ImportFormat::HupaUcm, &example, "example_subjectX.csv: no column 'time'; found"),
        (ImportFormat::T1dSim, &hupa_file, "HUPA0002P.csv: no column 'hour_of_day'; found"),
        (ImportFormat::T1dUom, &hupa_file, "no folder 'Glucose Data'"),
    ] {
        let message = import(format, path).expect_err("the wrong study").to_string();
        assert!(message.contains(says), "{message}");
    }
    let message = read_folder(&hupa).expect_err("not a cohort folder").to_string();
    assert!(message.contains("not a cohort folder; if it is a study's own data, import it"));
}
