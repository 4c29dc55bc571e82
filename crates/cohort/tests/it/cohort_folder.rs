//! The canonical folder: what is written is read back, and an error says where it is.

use std::fs;
use std::path::Path;

use cohort::{
    CellKind, Cells, Channel, Cohort, ParquetSink, Person, Record, RecordsFormat, Therapy,
    check_folder, new_folder, read_folder, write_folder,
};
use physiology::{BeatsPerMinute, Kilograms};
use proptest::prelude::*;

const PEOPLE: &str = "person_id,weight_kg,therapy,heart_rate_baseline_bpm\n";
const RECORDS: &str =
    "person_id,time,cgm_mg_dl,basal_u_h,bolus_u,carbs_g,heart_rate_bpm,steps,sleep_efficiency\n";
const ROW: &str = "a,2024-03-01T08:00:00,120,0.8,0,0,60,0,0\n";

fn folder_with(people: &str, records: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("people.csv"), people).expect("writable");
    fs::write(folder.path().join("records.csv"), records).expect("writable");
    folder
}

#[test]
fn a_folder_is_read_with_marks_crlf_gaps_and_further_columns() {
    let people = format!("\u{feff}{}a,70.5,aid,,ignored\r\nb,,unknown,0,\r\n", "X")
        .replace('X', "person_id,weight_kg,therapy,heart_rate_baseline_bpm,note\r\n");
    let records = "\u{feff}note,set_change,time,person_id,cgm_mg_dl,basal_u_h,bolus_u,carbs_g,\
                   heart_rate_bpm,steps,sleep_efficiency\r\n\
                   ,1,2024-03-01T08:00:00,a,120,0.8,0,0,60,0,0\r\n\
                   \"x,y\",,2024-03-01T08:00:00,b,,,,,-12.5,,1\r\n\
                   ,,2024-03-01T08:10:00,a,,,2.5,30,,,\r\n";
    let folder = folder_with(&people, records);
    let cohort = read_folder(folder.path()).expect("a good folder");
    let a = &cohort.people[0];
    assert_eq!((a.weight, a.therapy), (Some(Kilograms(70.5)), Therapy::Aid));
    assert_eq!(a.heart_rate_baseline, None);
    assert_eq!(a.record.start().to_string(), "2024-03-01 08:00:00");
    assert_eq!(a.record.cgm(), &[Some(120.0), None, None]);
    assert_eq!(a.record.bolus(), &[Some(0.0), None, Some(2.5)]);
    assert_eq!(a.record.set_change(), &[Some(1.0), None, None]);
    let (index, b) = cohort.find("b").expect("b is there");
    assert_eq!((index, b.heart_rate_baseline), (1, Some(BeatsPerMinute(0.0))));
    assert_eq!(b.record.heart_rate(), &[Some(-12.5)]);
}

/// `(people.csv after its header, records.csv after its header, what the error must say)`.
#[rustfmt::skip]
const WRONG: [(&str, &str, &str); 29] = [
    ("a,70,pump,\n", ROW, "people.csv, row 2, column therapy: 'pump' is not open_loop_pump, aid, mdi or unknown"),
    ("a,70,aid,\na,70,aid,\n", ROW, "people.csv, row 3, column person_id: person 'a' is listed twice"),
    ("a,heavy,aid,\n", ROW, "people.csv, row 2, column weight_kg: 'heavy' is not a number"),
    ("a,0.07,aid,\n", ROW, "people.csv, row 2, column weight_kg: 0.07 is outside 1 to 500 kg"),
    ("a,70,aid,nan\n", ROW, "column heart_rate_baseline_bpm: 'nan' is not a finite number"),
    ("../a,70,aid,\n", ROW, "people.csv, row 2, column person_id: '../a' is not a person's identifier"),
    ("\"=HYPERLINK(1)\",70,aid,\n", ROW, "'=HYPERLINK(1)' is not a person's identifier"),
    ("a,70,aid\n", ROW, "people.csv, row 2: 3 fields where the header has 4"),
    ("", ROW, "people.csv: no data row"),
    ("a,70,aid,\n", "", "records.csv: no data row"),
    ("a,70,aid,\nb,70,aid,\n", ROW, "records.csv: no row for person 'b'; remove the person"),
    ("b,70,aid,\n", ROW, "records.csv, row 2, column person_id: person 'a' is not in people.csv; add a row there"),
    ("a,,aid,\n", "a,2024-03-01T08:00:00,120,0.8,0,0,60,0,0\na,2024-03-01T08:00:00,120,0.8,0,0,60,0,0\n", "records.csv, row 3, column time: person 'a' has two rows at 2024-03-01 08:00:00; keep one"),
    ("a,,aid,\n", "a,2024-03-01T08:05:00,120,,,,,,\na,2024-03-01T08:00:00,120,,,,,,\n", "records.csv, row 3, column time: person 'a' at 2024-03-01 08:00:00 comes after 2024-03-01 08:05:00; sort"),
    ("a,,aid,\n", "a,2024-03-01T08:02:00,120,,,,,,\n", "records.csv, row 2, column time: 2024-03-01 08:02:00 is off the 5-minute grid"),
    ("a,,aid,\n", "a,2024-03-01T08:00:30,120,,,,,,\n", "off the 5-minute grid"),
    ("a,,aid,\n", "a,2024-03-01 08:00:00,120,,,,,,\n", "column time: '2024-03-01 08:00:00' is not a local time like 2024-03-01T08:05:00 without a zone"),
    ("a,,aid,\n", "a,2024-03-01T08:00:00Z,120,,,,,,\n", "'2024-03-01T08:00:00Z' is not a local time"),
    ("a,,aid,\n", "a,2024-02-30T08:00:00,120,,,,,,\n", "'2024-02-30T08:00:00' is not a local time"),
    ("a,,aid,\n", "a,,120,,,,,,\n", "records.csv, row 2, column time: '' is not a local time"),
    ("a,,aid,\n", "a,1990-01-01T00:00:00,120,,,,,,\na,2024-01-01T00:00:00,120,,,,,,\n", "records.csv, row 3, column time: person 'a' spans 12418 days, more than 7320"),
    ("a,,aid,\n", "a,2024-03-01T08:00:00,120,,-0.5,,,,\n", "records.csv, row 2, column bolus_u: -0.5 is outside 0 to 100 U; a negative value is not a dose"),
    ("a,,aid,\n", "a,2024-03-01T08:00:00,120,high,,,,,\n", "records.csv, row 2, column basal_u_h: 'high' is not a number"),
    ("a,,aid,\n", "a,2024-03-01T08:00:00,NaN,,,,,,\n", "column cgm_mg_dl: 'NaN' is not a finite number; leave the cell empty"),
    ("a,,aid,\n", "a,2024-03-01T08:00:00,120,,,inf,,,\n", "column carbs_g: 'inf' is not a finite number"),
    ("a,,aid,\n", "a,2024-03-01T08:00:00,6.7,,,,,,\n", "records.csv, column cgm_mg_dl: person 'a' has a median of 6.7: looks like mmol/L; multiply by 18 or import"),
    ("a,,aid,\n", "a,2024-03-01T08:00:00,0,,,,,,\n", "column cgm_mg_dl: 0 is outside 0 to 2000 mg/dL"),
    ("a,,aid,\n", "a,2024-03-01T08:00:00,120,,,,,,95\n", "column sleep_efficiency: 95 is outside 0 to 1"),
    ("a,,aid,\n", "a,2024-03-01T08:00:00,120,,,,-3,,\n", "column heart_rate_bpm: -3 is outside 0 to 300 1/min"),
];

#[test]
fn what_is_wrong_is_said_with_file_row_column_and_remedy() {
    for (people, records, says) in WRONG {
        let folder = folder_with(&format!("{PEOPLE}{people}"), &format!("{RECORDS}{records}"));
        let message = read_folder(folder.path()).expect_err(says).to_string();
        assert!(message.contains(says), "wanted: {says}\n   got: {message}");
    }
}

#[test]
fn missing_files_and_columns_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let refused = |folder: &Path| read_folder(folder).expect_err("refused").to_string();
    let message = refused(folder.path());
    assert!(message.starts_with("people.csv: no such file;"), "{message}");
    assert!(message.contains("if it is a study's own data, import it"), "{message}");
    fs::write(folder.path().join("people.csv"), format!("{PEOPLE}a,,aid,\n")).expect("writable");
    let message = refused(folder.path());
    assert!(message.starts_with("records.csv: no such file; put records.csv or"), "{message}");

    for (column, header) in
        [("person_id", RECORDS), ("time", RECORDS), ("cgm_mg_dl", RECORDS), ("person_id", PEOPLE)]
    {
        let header = header.replace(column, "other");
        let (people, records, file) = if header.starts_with("other,weight") {
            (header, RECORDS.to_owned(), "people.csv")
        } else {
            (PEOPLE.to_owned(), header, "records.csv")
        };
        let folder = folder_with(&(people + "a,,aid,\n"), &(records + ROW));
        let message = refused(folder.path());
        let says = format!("{file}: no column '{column}'; found ");
        assert!(message.starts_with(&says), "{message}");
    }
    let both = folder_with(&format!("{PEOPLE}a,,aid,\n"), &format!("{RECORDS}{ROW}"));
    fs::write(both.path().join("records.parquet"), b"PAR1").expect("writable");
    let message = refused(both.path());
    assert!(message.contains("both records.csv and records.parquet; remove one"), "{message}");
    let parquet = tempfile::tempdir().expect("a temporary folder");
    fs::write(parquet.path().join("people.csv"), format!("{PEOPLE}a,,aid,\n")).expect("writable");
    fs::write(parquet.path().join("records.parquet"), b"not Parquet").expect("writable");
    let message = refused(parquet.path());
    assert!(
        message.contains("records.parquet: not a readable table: it does not begin"),
        "{message}"
    );
}

#[test]
fn an_absent_column_is_not_recorded_and_an_empty_therapy_unknown() {
    let folder = folder_with(
        "person_id\na\n",
        "time,cgm_mg_dl,person_id\n2024-03-01T08:00:00,120,a\n2024-03-01T08:10:00,,a\n",
    );
    let cohort = read_folder(folder.path()).expect("three columns are enough");
    let person = &cohort.people[0];
    assert_eq!((person.therapy, person.weight), (Therapy::Unknown, None));
    assert_eq!(person.record.cgm(), &[Some(120.0), None, None]);
    let others = Channel::ALL.into_iter().filter(|channel| *channel != Channel::Cgm);
    for channel in others {
        assert!(person.record.channel(channel).iter().all(Option::is_none), "{channel:?}");
    }
    let folder = folder_with(&format!("{PEOPLE}a,,,\n"), &format!("{RECORDS}{ROW}"));
    assert_eq!(read_folder(folder.path()).expect("good").people[0].therapy, Therapy::Unknown);
}

#[test]
fn a_name_near_that_of_an_absent_column_is_refused() {
    for (header, says) in [
        (
            "person_id,time,cgm_mg_dl,set_chnage",
            "records.csv: unknown column 'set_chnage': did you mean 'set_change'? rename it",
        ),
        ("person_id,time,glucose", "unknown column 'glucose': did you mean 'cgm_mg_dl'?"),
        ("person_id,timestamp,cgm_mg_dl", "unknown column 'timestamp': did you mean 'time'?"),
        ("person_id,time,cgm_mg_dl,bolus", "unknown column 'bolus': did you mean 'bolus_u'?"),
    ] {
        let row = "a,2024-03-01T08:00:00,120,1".split(',').take(header.split(',').count());
        let row = row.collect::<Vec<_>>().join(",");
        let folder = folder_with("person_id\na\n", &format!("{header}\n{row}\n"));
        let message = read_folder(folder.path()).expect_err(says).to_string();
        assert!(message.contains(says), "{message}");
    }
    // Beside the column itself the near name is one of another column.
    let folder = folder_with(
        "person_id,height\na,180\n",
        "person_id,time,cgm_mg_dl,bolus_u,bolus\na,2024-03-01T08:00:00,120,1,2\n",
    );
    let cohort = read_folder(folder.path()).expect("both are there");
    assert_eq!(cohort.people[0].record.bolus(), &[Some(1.0)]);
}

#[test]
fn a_check_lists_every_fault_at_once() {
    let folder = folder_with(
        "person_id,therapy,weight\na,pump,70\na,aid,70\nb,aid,0.07\n",
        "person_id,time,cgm_mg_dl,bolus_u,note\n\
         a,2024-03-01T08:00:00,120,-1,x\n\
         a,2024-03-01T08:02:00,121,0,\n\
         a,2024-03-01T08:00:00,122,0,\n\
         a,2024-03-01T08:10:00,high,0\n\
         a,2024-03-01T08:15:00,high,two,\n\
         c,2024-03-01T08:15:00,120,0,\n",
    );
    let check = check_folder(folder.path());
    assert!(!check.passes());
    let faults: Vec<String> = check.faults.iter().map(ToString::to_string).collect();
    let expected = [
        "people.csv: unknown column 'weight': did you mean 'weight_kg'?",
        "people.csv, row 2, column therapy: 'pump' is not open_loop_pump",
        "people.csv, row 3, column person_id: person 'a' is listed twice",
        "records.csv, row 5: 4 fields where the header has 5",
        "records.csv, row 3, column time: 2024-03-01 08:02:00 is off the 5-minute grid",
        "records.csv, row 4, column time: person 'a' has two rows at",
        "records.csv, row 7, column person_id: person 'c' is not in people.csv",
        "records.csv: no row for person 'b'",
        "records.csv, row 6, column cgm_mg_dl: 'high' is not a number",
        "records.csv, row 2, column bolus_u: -1 is outside 0 to 100 U",
        "records.csv, row 6, column bolus_u: 'two' is not a number",
    ];
    for (fault, says) in faults.iter().zip(expected) {
        assert!(fault.starts_with(says), "wanted: {says}\n   got: {fault}");
    }
    assert_eq!(faults.len(), expected.len(), "{faults:#?}");
    assert!(check.remarks.contains(&"records.csv: column 'note' is unknown and ignored".into()));
    assert!(check.remarks.contains(&"records.csv: no column 'carbs_g': not recorded".into()));
    // The first of them is what reading says.
    assert_eq!(read_folder(folder.path()).expect_err("faulty").to_string(), faults[0]);
}

#[test]
fn a_check_goes_on_after_a_file_that_is_no_table() {
    let folder = folder_with("", "person_id,time,cgm_mg_dl\na,yesterday,120\n");
    let faults: Vec<String> =
        check_folder(folder.path()).faults.iter().map(ToString::to_string).collect();
    assert_eq!(faults, ["people.csv: no data row; a header and at least one row are needed"]);
    let missing = check_folder(&folder.path().join("nowhere"));
    let faults: Vec<String> = missing.faults.iter().map(ToString::to_string).collect();
    assert_eq!(faults.len(), 2, "{faults:?}");
    assert!(faults[1].starts_with("records.csv: no such file"), "{faults:?}");
}

#[test]
fn the_template_is_a_cohort_with_three_rows() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let target = folder.path().join("mine");
    new_folder(&target).expect("writable");
    let check = check_folder(&target);
    assert!(check.passes() && check.remarks.is_empty(), "{check:?}");
    let records = fs::read_to_string(target.join("records.csv")).expect("written");
    assert_eq!(records.lines().count(), 4, "{records}");
    assert_eq!(read_folder(&target).expect("good").people.len(), 1);
    let again = new_folder(&target).expect_err("there are files").to_string();
    assert!(again.contains("choose another name"), "{again}");
}

#[test]
fn sizes_are_looked_at_before_memory_is_spent() {
    let refused = |people: &str, records: &str| {
        let folder = folder_with(people, records);
        let started = std::time::Instant::now();
        let message = read_folder(folder.path()).expect_err("too large").to_string();
        // Milliseconds; half a minute before the columns were counted.
        assert!(started.elapsed().as_secs() < 5, "{:?}: {message}", started.elapsed());
        message
    };
    let wide: Vec<String> = (0..200_000).map(|i| format!("c{i}")).collect();
    let row = vec!["1"; wide.len()].join(",");
    let message = refused("person_id\na\n", &format!("{}\n{row}\n", wide.join(",")));
    assert!(message.contains("records.csv: 200000 columns, more than 4096"), "{message}");
    let message = refused("person_id\na\n", &"x".repeat(30 << 20));
    assert!(message.contains("records.csv, row 1: longer than 4 MiB"), "{message}");
    // A few rows that are far apart make a long grid each.
    let ids: Vec<String> = (0..20).map(|i| format!("p{i}")).collect();
    let rows: String = ids
        .iter()
        .map(|id| format!("{id},2000-01-01T00:00:00,100\n{id},2019-12-31T00:00:00,100\n"))
        .collect();
    let message = refused(
        &format!("person_id\n{}\n", ids.join("\n")),
        &format!("person_id,time,cgm_mg_dl\n{rows}"),
    );
    assert!(message.contains("the records span more than"), "{message}");
}

#[test]
fn a_small_parquet_file_of_very_many_rows_is_refused_unread() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("people.csv"), "person_id\na\n").expect("writable");
    let path = folder.path().join("records.parquet");
    let file = fs::File::create(&path).expect("writable");
    let columns = [("cgm_mg_dl", CellKind::Number), ("person_id", CellKind::Word)];
    let mut sink = ParquetSink::new("records.parquet", file, &columns).expect("a table");
    // Equal cells take next to no room: 40 million rows.
    const PIECE: usize = 4_000_000;
    for _ in 0..10 {
        let cells = vec![Cells::Numbers(vec![Some(100.0); PIECE]), Cells::Words(vec!["a"; PIECE])];
        sink.write(cells).expect("fits");
    }
    sink.finish().expect("written");
    let size = fs::metadata(&path).expect("written").len();
    assert!(size < 20 << 20, "{size} bytes");
    let message = read_folder(folder.path()).expect_err("too many").to_string();
    assert!(message.contains("records.parquet: 40000000 rows, more than 33554432"), "{message}");
}

fn small_cohort() -> Cohort {
    let start = "2024-03-01T08:00:00".parse().expect("a literal time");
    let mut record = Record::new(start, 6).expect("on the grid");
    // Numbers that differ from their neighbours in the seventeenth digit only.
    record.channel_mut(Channel::Cgm)[1] = Some(0.1 + 0.2 + 100.0);
    record.channel_mut(Channel::Basal)[1] = Some(4.0920000000000005);
    record.channel_mut(Channel::Basal)[3] = Some(1e-7);
    Cohort {
        people: vec![Person {
            id: "a".into(),
            weight: None,
            therapy: Therapy::Mdi,
            heart_rate_baseline: Some(BeatsPerMinute(61.5)),
            record,
        }],
    }
}

#[test]
fn written_bytes_are_exactly_these_and_empty_ends_keep_the_grid() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_folder(&small_cohort(), folder.path(), RecordsFormat::Csv).expect("writable");
    let text = fs::read_to_string(folder.path().join("records.csv")).expect("written");
    assert_eq!(
        text,
        "person_id,time,cgm_mg_dl,basal_u_h,bolus_u,carbs_g,heart_rate_bpm,steps,\
         sleep_efficiency,set_change\n\
         a,2024-03-01T08:00:00,,,,,,,,\n\
         a,2024-03-01T08:05:00,100.3,4.0920000000000005,,,,,,\n\
         a,2024-03-01T08:15:00,,1e-7,,,,,,\n\
         a,2024-03-01T08:25:00,,,,,,,,\n"
    );
    let people = fs::read_to_string(folder.path().join("people.csv")).expect("written");
    assert_eq!(people, format!("{PEOPLE}a,,mdi,61.5\n"));
    assert_eq!(read_folder(folder.path()).expect("good"), small_cohort());
    let names: Vec<_> = fs::read_dir(folder.path())
        .expect("readable")
        .map(|entry| entry.expect("readable").file_name())
        .collect();
    assert_eq!(names.len(), 2, "no partial file stays: {names:?}");
}

#[test]
fn cohorts_that_could_not_be_read_back_are_not_written() {
    let spoil = |change: &dyn Fn(&mut Cohort)| {
        let mut cohort = small_cohort();
        change(&mut cohort);
        cohort
    };
    for (cohort, says) in [
        (Cohort::default(), "people.csv: no data row"),
        (spoil(&|c| c.people[0].id = "a/b".into()), "'a/b' is not a person's identifier"),
        (spoil(&|c| c.people.push(c.people[0].clone())), "person 'a' is listed twice"),
        (
            spoil(&|c| c.people[0].record.channel_mut(Channel::Carbs)[2] = Some(f64::NAN)),
            "person 'a', step 2, column carbs_g: NaN is not a finite number",
        ),
        (
            spoil(&|c| c.people[0].record.channel_mut(Channel::Bolus)[2] = Some(-1.0)),
            "person 'a', step 2, bolus_u: -1 is outside 0 to 100 U",
        ),
        (
            spoil(&|c| c.people[0].record.channel_mut(Channel::Cgm)[1] = Some(5.5)),
            "looks like mmol/L",
        ),
    ] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let target = folder.path().join("cohort");
        let error = write_folder(&cohort, &target, RecordsFormat::Csv).expect_err(says);
        assert!(error.to_string().contains(says), "{error}");
        assert!(!target.exists(), "nothing is written");
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_folder(&small_cohort(), folder.path(), RecordsFormat::Csv).expect("writable");
    let error = write_folder(&small_cohort(), folder.path(), RecordsFormat::Parquet)
        .expect_err("two formats in one folder");
    assert!(error.to_string().contains("it already holds records.csv"), "{error}");
}

/// A number of a channel: any `f64` within the column's range.
fn cell(channel: Channel) -> impl Strategy<Value = Option<f64>> {
    let high = match channel {
        Channel::SleepEfficiency | Channel::SetChange => 1.0,
        Channel::HeartRate => 200.0,
        _ => 100.0,
    };
    let low = if channel == Channel::Cgm { 40.0 } else { 0.0 };
    prop_oneof![
        Just(None),
        (low..=high).prop_map(move |value: f64| {
            Some(if channel == Channel::SetChange { value.round() } else { value })
        }),
        Just(Some(low)),
    ]
}

fn person(id: usize) -> impl Strategy<Value = Person> {
    let therapies = prop::sample::select(Therapy::ALL.to_vec());
    let rows = prop::collection::vec(Channel::ALL.map(cell), 1..40);
    (rows, therapies, prop::option::of(1.0..500.0), prop::option::of(0.5..250.0), 0_usize..200_000)
        .prop_map(move |(rows, therapy, weight, baseline, shift)| {
            let epoch = "2019-12-30T23:35:00".parse().expect("a literal time");
            let far = Record::new(epoch, shift).expect("on the grid");
            let mut record = Record::new(far.time(shift), rows.len()).expect("on the grid");
            for (k, row) in rows.iter().enumerate() {
                for (channel, value) in Channel::ALL.into_iter().zip(row) {
                    record.channel_mut(channel)[k] = *value;
                }
            }
            Person {
                id: format!("p{id}"),
                weight: weight.map(Kilograms),
                therapy,
                heart_rate_baseline: baseline.map(BeatsPerMinute),
                record,
            }
        })
}

fn cohort() -> impl Strategy<Value = Cohort> {
    (person(0), prop::option::of(person(1)), prop::option::of(person(2))).prop_map(
        |(first, second, third)| Cohort {
            people: std::iter::once(first).chain(second).chain(third).collect(),
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    #[test]
    fn what_is_written_is_read_back_exactly_and_in_the_same_bytes(cohort in cohort()) {
        for format in [RecordsFormat::Csv, RecordsFormat::Parquet] {
            let (one, two) = (tempfile::tempdir()?, tempfile::tempdir()?);
            write_folder(&cohort, one.path(), format).expect("a good cohort");
            let read = read_folder(one.path()).expect("a good folder");
            prop_assert_eq!(&read, &cohort);
            write_folder(&read, two.path(), format).expect("a good cohort");
            for entry in fs::read_dir(one.path())? {
                let name = entry?.file_name();
                let bytes = fs::read(one.path().join(&name))?;
                prop_assert!(bytes == fs::read(two.path().join(&name))?, "{:?}", name);
            }
        }
    }
}
