//! Files of every format, damaged at random: read or refused with a message, never a panic.

use std::fs;

use cohort::{
    Channel, Cohort, ImportFormat, Person, Record, RecordsFormat, Therapy, import, read_folder,
    write_folder,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const PEOPLE: &str =
    "person_id,weight_kg,therapy,heart_rate_baseline_bpm\na,70,aid,\nb,,unknown,0\n";
const RECORDS: &str = "person_id,time,cgm_mg_dl,basal_u_h,bolus_u,carbs_g,heart_rate_bpm,steps,sleep_efficiency\n\
     a,2024-03-01T08:00:00,120,0.8,0,0,60,0,0\n\
     a,2024-03-01T08:05:00,121.5,0.8,1.5,20,61,10,0.25\n\
     b,2024-03-01T08:05:00,99,,,,-5.5,,\nb,2024-03-01T08:15:00,,,,,,,1\n";
const HUPA: &str = "time;glucose;calories;heart_rate;steps;basal_rate;bolus_volume_delivered;carb_input\n\
     2018-06-13T22:45:00;86.0;6.2;65.4;0.0;0.1;6.0;5.0\n\
     2018-06-13T22:50:00;88.0;6.2;65.5;3.0;0.1;0.0;0.0\n";
const T1DSIM: &str = "hour_of_day,cgm,sleep_efficiency,heart_rate_WRTbaseline,feat_is_weekend,\
                      input_insulin_ODEPop,input_meal_carbs_ODEPop\n\
                      0,128,0.97,-15.05,0,0.948,0\n0,126,0.97,-15.6,0,0.816,0\n";
/// Each file of the T1D-UOM layout.
const UOM: [(&str, &str); 6] = [
    ("Glucose Data/UoMGlucose1.csv", "bg_ts,value\n01/03/2024 08:00,7\n01/03/2024 09:00,8.1\n"),
    (
        "Insulin Data/Basal Data/UoMBasal1.csv",
        "basal_ts,basal_dose,insulin_kind,,\n01/03/2024 08:00,0.8,R,,\n01/03/2024 09:00,0,R,,\n",
    ),
    ("Insulin Data/Bolus Data/UoMBolus1.csv", "bolus_ts,bolus_dose\n01/03/2024 08:20,2.5\n"),
    (
        "Nutrition Data/UoMNutrition1.csv",
        "meal_ts,meal_type,meal_tag,carbs_g\n01/03/2024 08:20,Lunch,\"Fish, chips\",40\n01/03/2024,Snack,,5\n",
    ),
    (
        "Activity Data/UoMActivity1.csv",
        "activity_ts,step_count,duration_s,start_time_offset_s\n01/03/2024 08:15,90,900,0\n",
    ),
    (
        "Sleep Data/UoM1sleeptime.csv",
        "duration_in_sec,start_date_ts,start_time_offset_s,awake_s,sleep_levels_map.deep\n\
         600,01/03/2024 08:30,0,0,\"[{\"\"startTimeInSeconds\"\":1709281800,\"\"endTimeInSeconds\"\":1709282400}]\"\n",
    ),
];

/// A change to bytes: cut, overwritten or repeated.
#[derive(Debug, Clone)]
pub(crate) enum Mangle {
    Cut(prop::sample::Index),
    Set(prop::sample::Index, u8),
    Insert(prop::sample::Index, Vec<u8>),
    Repeat(prop::sample::Index, prop::sample::Index),
}

pub(crate) fn mangle() -> impl Strategy<Value = Mangle> {
    use prop::sample::Index;
    let spiteful = prop::sample::select(vec![
        b"\"".to_vec(),
        b",".to_vec(),
        b"\n".to_vec(),
        b"\r".to_vec(),
        b"\0".to_vec(),
        b"\xEF\xBB\xBF".to_vec(),
        b"\xFF".to_vec(),
        b"-".to_vec(),
        b"1e999".to_vec(),
        b"=1+1".to_vec(),
        b"9999-12-31T23:55:00".to_vec(),
        b"\"\n\"".to_vec(),
        b"#".to_vec(),
    ]);
    prop_oneof![
        any::<Index>().prop_map(Mangle::Cut),
        (any::<Index>(), any::<u8>()).prop_map(|(at, byte)| Mangle::Set(at, byte)),
        (any::<Index>(), spiteful).prop_map(|(at, bytes)| Mangle::Insert(at, bytes)),
        (any::<Index>(), any::<Index>()).prop_map(|(from, to)| Mangle::Repeat(from, to)),
    ]
}

pub(crate) fn mangled(mut bytes: Vec<u8>, changes: &[Mangle]) -> Vec<u8> {
    for change in changes {
        if bytes.is_empty() {
            break;
        }
        match change {
            Mangle::Cut(at) => bytes.truncate(at.index(bytes.len())),
            Mangle::Set(at, byte) => {
                let at = at.index(bytes.len());
                bytes[at] = *byte;
            }
            Mangle::Insert(at, extra) => {
                let at = at.index(bytes.len());
                bytes.splice(at..at, extra.iter().copied());
            }
            Mangle::Repeat(from, to) => {
                let (from, to) = (from.index(bytes.len()), to.index(bytes.len()));
                let piece = bytes[from.min(to)..from.max(to)].to_vec();
                bytes.extend(piece);
            }
        }
    }
    bytes
}

/// Imports a damaged source; what is read must be fit to be written.
pub(crate) fn imports_or_refuses(format: ImportFormat, source: &std::path::Path) {
    match import(format, source) {
        Ok(import) => {
            let folder = tempfile::tempdir().expect("a temporary folder");
            write_folder(&import.cohort, folder.path(), RecordsFormat::Csv)
                .expect("what is imported can be written");
            for totals in
                import.report.people.iter().filter_map(|person| person.totals.as_ref()).flatten()
            {
                assert!(totals.closes(), "{totals:?}");
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

#[test]
fn undamaged_files_are_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("people.csv"), PEOPLE).expect("writable");
    fs::write(folder.path().join("records.csv"), RECORDS).expect("writable");
    assert_eq!(read_folder(folder.path()).expect("good").people.len(), 2);
    for (format, name, text) in [
        (ImportFormat::HupaUcm, "HUPA1.csv", HUPA),
        (ImportFormat::T1dSim, "example_subject1.csv", T1DSIM),
    ] {
        fs::write(folder.path().join(name), text).expect("writable");
        assert_eq!(import(format, folder.path()).expect("good").cohort.people.len(), 1);
    }
    uom(folder.path(), usize::MAX, &[]);
    let uom = import(ImportFormat::T1dUom, folder.path()).expect("good");
    assert_eq!(uom.cohort.people[0].record.len(), 12);
}

/// Writes the T1D-UOM layout with one file damaged.
fn uom(folder: &std::path::Path, damaged: usize, changes: &[Mangle]) {
    for (i, (name, text)) in UOM.into_iter().enumerate() {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().expect("inside a folder")).expect("writable");
        let bytes = text.as_bytes().to_vec();
        let bytes = if i == damaged { mangled(bytes, changes) } else { bytes };
        fs::write(path, bytes).expect("writable");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    /// What is read can be written and read again.
    #[test]
    fn damaged_cohort_folders(
        changes in prop::collection::vec(mangle(), 1..5),
        in_people in any::<bool>(),
    ) {
        let folder = tempfile::tempdir()?;
        let (people, records) = (PEOPLE.as_bytes().to_vec(), RECORDS.as_bytes().to_vec());
        let (people, records) = if in_people {
            (mangled(people, &changes), records)
        } else {
            (people, mangled(records, &changes))
        };
        fs::write(folder.path().join("people.csv"), people)?;
        fs::write(folder.path().join("records.csv"), records)?;
        match read_folder(folder.path()) {
            Ok(cohort) => {
                let again = tempfile::tempdir()?;
                write_folder(&cohort, again.path(), RecordsFormat::Csv).expect("was read");
                prop_assert_eq!(read_folder(again.path()).expect("was written"), cohort);
            }
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }

    #[test]
    fn damaged_single_files(changes in prop::collection::vec(mangle(), 1..4)) {
        let folder = tempfile::tempdir()?;
        for (format, name, text) in [
            (ImportFormat::HupaUcm, "HUPA1.csv", HUPA),
            (ImportFormat::T1dSim, "example_subject1.csv", T1DSIM),
        ] {
            let path = folder.path().join(name);
            fs::write(&path, mangled(text.as_bytes().to_vec(), &changes))?;
            imports_or_refuses(format, &path);
        }
    }

    #[test]
    fn damaged_event_folders(
        changes in prop::collection::vec(mangle(), 1..4),
        which in 0..UOM.len(),
    ) {
        let folder = tempfile::tempdir()?;
        uom(folder.path(), which, &changes);
        imports_or_refuses(ImportFormat::T1dUom, folder.path());
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(2024),
        ..ProptestConfig::with_cases(300)
    })]

    /// The reader of Parquet belongs to the table library and panics on some damage, which becomes
    /// an error. The seed is fixed: a damaged page length can make the library request more memory
    /// than there is, which no caller can catch.
    #[test]
    fn damaged_parquet(changes in prop::collection::vec(mangle(), 1..4)) {
        let start = "2024-03-01T08:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, 3).expect("on the grid");
        record.channel_mut(Channel::Cgm)[1] = Some(100.5);
        let person = Person {
            id: "a".into(),
            weight: None,
            therapy: Therapy::Mdi,
            heart_rate_baseline: None,
            record,
        };
        let folder = tempfile::tempdir()?;
        let cohort = Cohort { people: vec![person] };
        write_folder(&cohort, folder.path(), RecordsFormat::Parquet).expect("writable");
        let path = folder.path().join("records.parquet");
        fs::write(&path, mangled(fs::read(&path)?, &changes))?;
        if let Err(error) = read_folder(folder.path()) {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}
