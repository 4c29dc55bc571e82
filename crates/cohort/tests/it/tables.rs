//! Tables that anybody may bring, good and bad.

use std::fs;
use std::path::PathBuf;

use cohort::{Channel, Import, ImportFormat, TableOptions, Therapy, guess_table, import_with};
use proptest::prelude::*;

/// Writes files and imports all of them.
fn import(files: &[(&str, &str)], change: impl Fn(&mut TableOptions)) -> Result<Import, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let paths: Vec<PathBuf> = files
        .iter()
        .map(|(name, text)| {
            let path = folder.path().join(name);
            fs::write(&path, text).expect("writable");
            path
        })
        .collect();
    let mut options = TableOptions::default();
    options.add_map("time=t,glucose=g").expect("a map");
    change(&mut options);
    import_with(ImportFormat::Table, &paths, &options).map_err(|error| error.to_string())
}

fn same(_: &mut TableOptions) {}

#[test]
fn readings_are_averaged_and_doses_summed_on_floored_steps() {
    let import = import(
        &[(
            "p.csv",
            "t,g,b,c\n2024-03-01 08:01,100,,\n2024-03-01 08:04:59,110,1.5,20\n\
             2024-03-01 08:03,,0.5,5\n2024-03-01 08:16,130,,\n2024-03-01 08:19,,,10\n\
             2024-03-02 08:00,,9,\n",
        )],
        |options| options.add_map("bolus=b,carbs=c").expect("a map"),
    )
    .expect("good");
    let record = &import.cohort.people[0].record;
    assert_eq!(record.start().to_string(), "2024-03-01 08:00:00");
    assert_eq!(record.cgm(), &[Some(105.0), None, None, Some(130.0)]);
    assert_eq!(record.bolus(), &[Some(2.0), Some(0.0), Some(0.0), Some(0.0)]);
    assert_eq!(record.carbs(), &[Some(25.0), Some(0.0), Some(0.0), Some(10.0)]);
    // 9 U a day later lie outside.
    let bolus = &import.report.people[0].totals.as_ref().expect("totals")[0];
    assert_eq!((bolus.source, bolus.record, bolus.left_out), (11.0, 2.0, 9.0));
}

#[test]
fn every_mapped_column_is_read_or_refused() {
    let file =
        ("p.csv", "t,g,meal,correction\n2024-03-01 08:00,100,5,\n2024-03-01 08:05,110,1,2\n");
    let with =
        |map: &'static str| import(&[file], move |options| options.add_map(map).expect("a map"));
    let absent = with("bolus=meals").expect_err("misspelt");
    assert!(absent.contains("'meals'") && absent.contains("correction"), "{absent}");
    // Amounts of several columns are summed; of readings there is one column.
    let both = with("bolus=meal,bolus=correction").expect("good");
    assert_eq!(both.cohort.people[0].record.bolus(), &[Some(5.0), Some(3.0)]);
    let twice = with("glucose=meal").expect_err("two columns");
    assert!(twice.contains("'g' and 'meal' of p.csv are both glucose"), "{twice}");
}

#[test]
fn a_row_that_stands_in_two_exports_of_a_person_counts_once() {
    let first =
        "t,who,g,b\n2024-03-01 08:00,a,100,5\n2024-03-01 08:05,a,110,\n2024-03-01 08:00,b,100,5\n";
    let second = "t,who,g,b\n2024-03-01 08:00,a,100,5\n2024-03-01 08:10,a,120,1\n";
    let import = import(&[("one.csv", first), ("two.csv", second)], |options| {
        options.add_map("person=who,bolus=b").expect("a map");
    })
    .expect("good");
    let doses = |at: usize| import.cohort.people[at].record.bolus().to_vec();
    assert_eq!(doses(0), [Some(5.0), Some(0.0), Some(1.0)]);
    assert_eq!(doses(1), [Some(5.0)]);
}

#[test]
fn pauses_of_a_log_of_every_step_are_not_recorded() {
    let row = |step: u32, grams: &str| {
        let (day, hour, minute) = (1 + step / 288, step / 12 % 24, 5 * (step % 12));
        format!("2024-03-{day:02} {hour:02}:{minute:02},100,{grams}\n")
    };
    // Two days of zeros with a meal, four days of glucose alone, and a day of zeros.
    let carbs = |step: u32| match step {
        100 => "40",
        _ if (576..1728).contains(&step) => "",
        _ => "0",
    };
    let text: String = (0..2016).map(|step| row(step, carbs(step))).collect();
    let map = |options: &mut TableOptions| options.add_map("carbs=c").expect("a map");
    let dense = import(&[("p.csv", &format!("t,g,c\n{text}"))], map).expect("good");
    let carbs = dense.cohort.people[0].record.carbs();
    assert_eq!(
        (carbs[100], carbs[575], carbs[576], carbs[1728]),
        (Some(40.0), Some(0.0), None, Some(0.0))
    );
    assert_eq!(carbs.iter().flatten().count(), 576 + 288);
}

#[test]
fn shares_of_sleep_are_told_from_per_cent_by_their_middle() {
    let read = |values: [&str; 3]| {
        let rows = values.iter().zip(["00", "05", "10"]);
        let rows: String =
            rows.map(|(value, minute)| format!("2024-03-01 08:{minute},100,{value}\n")).collect();
        import(&[("p.csv", &format!("t,g,s\n{rows}"))], |options| {
            options.add_map("sleep=s").expect("a map");
        })
    };
    let shares = |values| {
        let import = read(values).expect("good");
        let told = format!("{:?}", import.report.inferences);
        assert!(told.contains("sleep efficiency"), "{told}");
        import.cohort.people[0].record.channel(Channel::SleepEfficiency).to_vec()
    };
    assert_eq!(shares(["0.5", "0.75", "1"]), [Some(0.5), Some(0.75), Some(1.0)]);
    assert_eq!(shares(["50", "1", "100"]), [Some(0.5), Some(0.01), Some(1.0)]);
    let beyond = read(["0.93", "0.97", "1.01"]).expect_err("no share");
    assert!(beyond.contains("1.01 is outside 0 to 1"), "{beyond}");
}

#[test]
fn basal_rates_hold_and_amounts_become_rates() {
    let text = "t,g,b\n2024-03-01 08:00,100,1.2\n2024-03-01 08:05,100,1.2\n\
                2024-03-01 08:10,100,0.6\n2024-03-01 08:15,100,0.6\n";
    let with = |unit: &'static str| {
        import(&[("p.csv", text)], move |options| {
            options.add_map("basal=b").expect("a map");
            options.add_unit(unit).expect("a unit");
        })
        .expect("good")
    };
    let near = |import: &Import, expected: [f64; 4]| {
        let found = import.cohort.people[0].record.basal().to_vec();
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.is_some_and(|rate| (rate - expected).abs() < 1e-9), "{found:?}");
        }
    };
    near(&with("basal=U/h"), [1.2, 1.2, 0.6, 0.6]);
    near(&with("basal=U/day"), [0.05, 0.05, 0.025, 0.025]);
    near(&with("basal=U/5min"), [14.4, 14.4, 7.2, 7.2]);
    let found_out = with("basal=U");
    near(&found_out, [14.4, 14.4, 7.2, 7.2]);
    assert_eq!(found_out.cohort.people[0].therapy, Therapy::Aid);
    let total = &found_out.report.people[0].totals.as_ref().expect("totals")[0];
    assert!((total.source - 3.6).abs() < 1e-9 && total.closes(), "{total:?}");
}

#[test]
fn a_change_of_the_rate_within_a_step_is_weighted() {
    let import = import(
        &[
            ("cgm.csv", "t,g\n2024-03-01 08:00,100\n2024-03-01 10:00,120\n"),
            ("basal.csv", "t,rate\n2024-03-01 07:00,1\n2024-03-01 08:02,2\n2024-03-01 09:30,0\n2024-03-01 10:10,1\n"),
        ],
        |options| options.add_map("basal=rate").expect("a map"),
    )
    .expect("good");
    let person = &import.cohort.people[0];
    assert_eq!((person.id.as_str(), person.therapy), ("cgm", Therapy::OpenLoopPump));
    let basal = person.record.basal();
    // 2 min at 1 U/h and 3 min at 2 U/h.
    assert!(basal[0].is_some_and(|rate| (rate - 1.6).abs() < 1e-9), "{basal:?}");
    assert_eq!((basal[1], basal[18], basal[24]), (Some(2.0), Some(0.0), Some(0.0)));
    assert!(import.report.people[0].totals.as_ref().expect("totals")[0].closes());
}

#[test]
fn a_controllers_changes_hold_and_rows_that_repeat_the_rate_do_not() {
    let steps = |rates: &[(u32, f64)]| {
        let mut cgm = String::from("t,g\n");
        for k in 0..36 {
            cgm += &format!("2024-03-01 {:02}:{:02},120\n", 8 + k / 12, 5 * (k % 12));
        }
        let mut basal = String::from("t,rate\n");
        for (minute, rate) in rates {
            basal += &format!("2024-03-01 {:02}:{:02},{rate}\n", 8 + minute / 60, minute % 60);
        }
        let import = import(&[("cgm.csv", &cgm), ("basal.csv", &basal)], |options| {
            options.add_map("basal=rate").expect("a map");
        })
        .expect("good");
        import.cohort.people[0].record.basal().iter().flatten().count()
    };
    // An hour without a row: the controller changed nothing, or nothing is known of it.
    assert_eq!(steps(&[(0, 1.0), (5, 1.5), (10, 0.0), (70, 1.1), (75, 0.2), (80, 0.3)]), 16);
    assert_eq!(steps(&[(0, 1.0), (5, 1.0), (10, 1.0), (70, 1.0), (75, 1.0), (80, 1.0)]), 8);
}

#[test]
fn the_order_of_day_and_month_is_found_out_or_asked_for() {
    let start = |import: Result<Import, String>| {
        import.map(|import| import.cohort.people[0].record.start().to_string())
    };
    for (text, expected) in [
        ("t,g\n05/03/2024 08:00,100\n13/03/2024 08:00,100\n", "2024-03-05 08:00:00"),
        ("t,g\n03/05/2024 08:00,100\n03/13/2024 08:00,100\n", "2024-03-05 08:00:00"),
        // Three days in a row under one order, three months under the other.
        (
            "t,g\n04/03/2024 08:00,100\n05/03/2024 08:00,100\n06/03/2024 08:00,9e1\n",
            "2024-03-04 08:00:00",
        ),
    ] {
        assert_eq!(start(import(&[("p.csv", text)], same)), Ok(expected.into()), "{text}");
    }
    let open = "t,g\n04/03/2024 08:00,100\n04/03/2024 08:05,100\n";
    let error = import(&[("p.csv", open)], same).expect_err("open");
    assert!(
        error.starts_with("p.csv, row 2, column t: '04/03/2024 08:00' may have the day"),
        "{error}"
    );
    assert!(error.ends_with("say --dates day-first or --dates month-first"), "{error}");
    let told = import(&[("p.csv", open)], |options| {
        options.dates = Some(cohort::DateOrder::MonthFirst);
    });
    assert_eq!(start(told), Ok("2024-04-03 08:00:00".into()));
    // Another file of the same make decides.
    let two = import(
        &[("a.csv", open), ("b.csv", "t,g\n13/03/2024 08:00,100\n14/03/2024 08:05,99\n")],
        same,
    );
    assert_eq!(start(two), Ok("2024-03-04 08:00:00".into()));
    let both = import(&[("p.csv", "t,g\n13/03/2024 08:00,1e2\n03/13/2024 08:00,99\n")], same);
    assert!(both.expect_err("contradiction").contains("row 3, column t: '03/13/2024"));
}

#[test]
fn an_hour_that_stands_twice_on_the_wall_clock_is_not_averaged() {
    let rows = ["01:55,100", "02:00,101", "02:55,102", "02:00,201", "02:30,202", "03:00,103"]
        .map(|row| format!("2024-10-27 {row}\n"));
    let newest_first: String = rows.iter().rev().cloned().collect();
    for rows in [rows.concat(), newest_first] {
        let import = import(&[("p.csv", &format!("t,g\n{rows}"))], |options| {
            options.zone = Some("Europe/Madrid".into());
        })
        .expect("good");
        let cgm = import.cohort.people[0].record.cgm();
        assert_eq!(
            (cgm[1], cgm[7], cgm[12], cgm[13]),
            (Some(101.0), Some(202.0), Some(102.0), Some(103.0)),
            "{rows}"
        );
    }
    let skipped = "t,g\n2024-03-31 01:55,100\n2024-03-31 02:10,101\n2024-03-31 03:00,102\n";
    let import = self::import(&[("p.csv", skipped)], |options| {
        options.zone = Some("Europe/Madrid".into());
    })
    .expect("good");
    let note = import.report.notes[0].to_string();
    assert!(note.contains("row 3, column t: times in the hour that the clock skipped"), "{note}");
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let good = "t,g\n2024-03-01 08:00,100\n";
    for (text, says) in [
        ("", "p.csv: no data row"),
        ("t,g\n", "p.csv: no data row"),
        ("t,g\n2024-03-01 08:00,=SUM(A1)\n", "p.csv, row 2, column g: '=SUM(A1)' is not a number"),
        ("t,g\n2024-03-01 08:00,12o\n", "p.csv, row 2, column g: '12o' is not a number"),
        ("t,g\nyesterday,100\n", "p.csv, row 2, column t: 'yesterday' is not a time like"),
        ("t,g\n,100\n", "p.csv, row 2, column t: '' is not a time like"),
        (
            "t,g\n2024-03-01 08:00,-100\n2024-03-01 08:05,99\n",
            "p.csv, row 2, column g: -100 is outside 0 to 2000",
        ),
        (
            "t,g\n2024-03-01 08:00,100\n2024-03-01\n",
            "p.csv, row 3: 1 fields where the header has 2",
        ),
        ("t,g\n2024-03-01 08:00,\"100\n", "p.csv, row 2: a quote that is never closed"),
        ("t,glu\n2024-03-01 08:00,100\n", "p.csv: no column 'g'; found t, glu"),
        ("when,g\n2024-03-01 08:00,100\n", "p.csv: no column 't'; found when, g"),
        ("t,g\n2024-03-01,100\n", "no sensor reading of anyone"),
        ("t,g\n0001-03-01 08:00,100\n", "a time within the years 1900 to 2199"),
        (
            "t,g\n2024-03-01 08:00,100\n2034-03-01 08:00,100\n",
            "p.csv, column g: person 'p' spans 3652 days, more than 28; a time is probably wrong",
        ),
        ("PK\u{3}\u{4}", "not an Excel workbook, or cut off"),
    ] {
        let error = import(&[("p.csv", text)], same).expect_err(says);
        assert!(error.contains(says), "wanted: {says}\n   got: {error}");
    }
    for (change, says) in [
        (
            Box::new(|o: &mut TableOptions| o.zone = Some("Madrid".into()))
                as Box<dyn Fn(&mut TableOptions)>,
            "did you mean 'Europe/Madrid'?",
        ),
        (Box::new(|o| o.utc = true), "say also where the person lived"),
        (
            Box::new(|o| o.add_unit("glucose=mmol/L").expect("a unit")),
            "said to be mmol/L, but a median of 100.0 is mg/dL",
        ),
        (Box::new(|o| o.add_map("person=who").expect("a map")), "p.csv: no column 'who'"),
        (Box::new(|o| o.columns.clear()), "--map: say which column is what"),
    ] {
        let error = import(&[("p.csv", good)], change).expect_err(says);
        assert!(error.contains(says), "wanted: {says}\n   got: {error}");
    }
    let mixed = [("a.csv", good), ("b.csv", good), ("c.csv", "t,x\n2024-03-01 08:00,1\n")];
    let error = import(&mixed, |o| o.add_map("bolus=x").expect("a map")).expect_err("whose?");
    assert!(error.contains("'c.csv' has none, so whose it is stays open"), "{error}");
    let wrong = import_with(ImportFormat::HupaUcm, &["x".into()], &{
        let mut options = TableOptions::default();
        options.add_map("time=t").expect("a map");
        options
    });
    assert!(wrong.expect_err("no map").to_string().contains("hupa-ucm needs none of --map"));
}

#[test]
fn a_very_long_line_and_very_many_columns_are_refused_early() {
    let long = format!("t,g\n2024-03-01 08:00,{}", "1".repeat(6 << 20));
    let error = import(&[("p.csv", &long)], same).expect_err("too long");
    assert!(error.contains("p.csv, row 2: longer than 4 MiB"), "{error}");
    let wide = format!("t,g{}\n", ",x".repeat(200_000));
    let error = import(&[("p.csv", &(wide.clone() + &wide))], same).expect_err("too wide");
    assert!(error.contains("columns, more than 4096"), "{error}");
}

#[test]
fn a_folder_of_something_else_has_no_column_that_is_mapped() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("a.csv"), "x,y\n1,2\n").expect("writable");
    let from = |format| {
        import_with(format, &[folder.path().to_owned()], &TableOptions::default())
            .expect_err("of another study")
            .to_string()
    };
    let dexcom = from(ImportFormat::Dexcom);
    assert!(
        dexcom.contains("a.csv: no column 'Timestamp (YYYY-MM-DDThh:mm:ss)'; found x, y"),
        "{dexcom}"
    );
    assert!(from(ImportFormat::Libre).contains("no column 'Device Timestamp'"));
    let guess = guess_table(&[folder.path().to_owned()], None).expect("a table");
    assert_eq!((guess.map.as_str(), guess.missing.len()), ("", 2));
}

#[test]
fn insulin_on_dates_alone_is_in_the_totals() {
    for (map, unit, therapy) in
        [("long_acting=x", None, Therapy::Mdi), ("basal=x", Some("basal=U/5min"), Therapy::Unknown)]
    {
        let text = "t,g,x\n2024-03-01 08:00,100,\n2024-03-01,,12\n2024-03-02,,3\n";
        let import = import(&[("p.csv", text)], |options| {
            options.add_map(map).expect("a map");
            if let Some(unit) = unit {
                options.add_unit(unit).expect("a unit");
            }
        })
        .expect("good");
        let totals = import.report.people[0].totals.as_ref().expect("totals");
        let found: Vec<_> =
            totals.iter().map(|t| (t.column.as_str(), t.source, t.record, t.left_out)).collect();
        assert_eq!(found, [("basal_u_h", 15.0, 0.0, 15.0)], "{map}");
        assert_eq!(import.cohort.people[0].therapy, therapy, "{map}");
    }
}

#[test]
fn people_whose_names_become_one_are_not_merged() {
    let text = "t,g\n2024-03-01 08:00,100\n";
    let error = import(&[("Müller.csv", text), ("Möller.csv", text)], same).expect_err("one name");
    let says = "would both be called M_ller; use letters and digits that differ";
    assert!(error.starts_with("Möller.csv: ") && error.contains(says), "{error}");
    assert!(error.contains("'Möller' and 'Müller' of Müller.csv"), "{error}");

    let who = |options: &mut TableOptions| options.add_map("person=who").expect("a map");
    let row = |name: &str| format!("2024-03-01 08:00,100,{name}\n");
    let both = format!("t,g,who\n{}{}", row("p 1"), row("p_1"));
    let error = import(&[("a.csv", &both)], who).expect_err("one name");
    assert!(error.contains("a.csv, row 3, column who: 'p_1' is not a name that stays"), "{error}");
    let both = format!("t,g,who\n{}{}", row("p_1"), row("p 1"));
    assert!(import(&[("a.csv", &both)], who).is_err());
    let (one, other) = (format!("t,g,who\n{}", row("p 1")), format!("t,g,who\n{}", row("p_1")));
    let error = import(&[("a.csv", &one), ("b.csv", &other)], who).expect_err("one name");
    assert!(error.contains("'p_1' and 'p 1' of a.csv would both be called p_1"), "{error}");

    // A name that changes is noted, and one person in two files stays one.
    let import = import(&[("a.csv", &one), ("b.csv", &one)], who).expect("one person");
    assert_eq!(import.cohort.people.len(), 1);
    let says = "'p 1' is called p_1: names of people and files";
    assert!(import.report.notes.iter().any(|note| note.to_string().contains(says)));
}

const EXPORTS: [(ImportFormat, &str); 4] = [
    (
        ImportFormat::Table,
        "t;g;b;c;s\n13/03/2024 08:00;5,6;0,5;10;1\n13/03/2024 08:05;LO;;;\n\
                           14/03/2024 08:05;7,1;1.234,5;;\n",
    ),
    (ImportFormat::Table, "t,g,b,c,s\n1710316800,100,0.5,,yes\n1710317100,101,,NA,no\n"),
    (
        ImportFormat::Dexcom,
        "Index,Timestamp (YYYY-MM-DDThh:mm:ss),Event Type,Event Subtype,\
        Glucose Value (mg/dL),Insulin Value (u),Carb Value (grams)\n1,,FirstName,,,,\n\
        2,2024-03-01T08:00:00,EGV,,100,,\n3,2024-03-01T08:01:00,Insulin,Long-Acting,,12,\n",
    ),
    (
        ImportFormat::Libre,
        "Glucose Data,Generated on\nDevice Timestamp,Record Type,\
        Historic Glucose mmol/L,Rapid-Acting Insulin (units),Carbohydrates (grams)\n\
        13-06-2024 08:00,0,5.6,,\n13-06-2024 08:05,4,,2,\n",
    ),
];

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    /// Cut, overwritten and repeated bytes give a message or a cohort that can be written.
    #[test]
    fn damaged_tables(
        which in 0..EXPORTS.len(),
        cut in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
        put in prop::sample::select(vec![&b"\""[..], b",", b"\n", b";", b"\0", b"\xFF", b"1e999",
            b"9999-12-31 23:59", b"+14:00", b"-", b"99/99/9999", b"2024-10-27T01:30:00Z", b"1"]),
        how in 0..3_u8,
    ) {
        let (format, text) = EXPORTS[which];
        let mut bytes = text.as_bytes().to_vec();
        match how {
            0 => bytes.truncate(cut.index(bytes.len())),
            1 => { let at = at.index(bytes.len()); bytes.splice(at..at, put.iter().copied()); }
            _ => { let at = at.index(bytes.len()); bytes[at] = put[0]; }
        }
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("p.csv");
        fs::write(&path, bytes)?;
        let mut options = TableOptions { zone: Some("Europe/Madrid".into()), ..Default::default() };
        if format == ImportFormat::Table {
            options.add_map("time=t,glucose=g,bolus=b,carbs=c,set_change=s").expect("a map");
        }
        match import_with(format, std::slice::from_ref(&path), &options) {
            Ok(import) => {
                let out = folder.path().join("out");
                let written =
                    cohort::write_folder(&import.cohort, &out, cohort::RecordsFormat::Csv);
                prop_assert!(written.is_ok(), "{:?}", written);
                for totals in import.report.people.iter().flat_map(|person| person.totals.iter().flatten()) {
                    prop_assert!(totals.closes(), "{:?}", totals);
                }
            }
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
        drop(guess_table(&[path], None));
    }
}
