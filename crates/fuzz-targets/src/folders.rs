//! Cohort folders and other people's formats.

use std::fs;
use std::io::{Cursor, Read as _, Write as _};
use std::path::{Path, PathBuf};

use cohort::{
    Cohort, ImportFormat, RecordsFormat, TableOptions, check_folder, guess_table, import_with,
    read_folder, write_folder,
};
use tempfile::TempDir;

use crate::{pack, unpack};

/// The folder of the fixtures.
fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures")
}

/// A folder, in memory where there is such a place.
fn folder() -> TempDir {
    let memory = Path::new("/dev/shm");
    let made = if memory.is_dir() { TempDir::new_in(memory) } else { TempDir::new() };
    made.expect("a folder can be made")
}

/// Writes packed files into a folder; those that the system refuses are left out.
fn unpack_into(bytes: &[u8], place: &Path) {
    for (name, content) in unpack(bytes) {
        let path = place.join(name);
        let parent = path.parent().expect("inside the folder");
        let _ = fs::create_dir_all(parent).and_then(|()| fs::write(&path, content));
    }
}

/// The files below a folder, in order.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a fixture");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("readable").path()).collect();
    paths.sort();
    let files = |path: PathBuf| if path.is_dir() { files_below(&path) } else { vec![path] };
    paths.into_iter().flat_map(files).collect()
}

/// The files below a folder, packed.
fn packed(place: &Path) -> Vec<u8> {
    let files = files_below(place).into_iter().map(|path| {
        let name = path.strip_prefix(place).expect("below it").to_string_lossy().into_owned();
        (name, fs::read(&path).expect("a fixture"))
    });
    pack(&files.collect::<Vec<_>>())
}

/// The first lines of a text, so that a fuzzer has little to carry.
fn first_lines(text: &[u8], lines: usize) -> Vec<u8> {
    text.split_inclusive(|byte| *byte == b'\n').take(lines).flatten().copied().collect()
}

/// Longest records that are written again, steps: a year. One damaged date makes decades of empty steps, and a fuzzer would
/// spend its hours on writing them.
const WRITTEN_STEPS: usize = 366 * 24 * 12;

/// What is read can be written and read again.
fn written_again(cohort: &Cohort, format: RecordsFormat) {
    if cohort.people.iter().map(|person| person.record.len()).sum::<usize>() > WRITTEN_STEPS {
        return;
    }
    let again = folder();
    write_folder(cohort, again.path(), format).expect("what was read can be written");
    let back = read_folder(again.path()).expect("what was written can be read");
    assert_eq!(&back, cohort);
}

/// Reads a cohort folder in both ways.
pub(crate) fn read_cohort(bytes: &[u8], format: RecordsFormat) {
    let place = folder();
    unpack_into(bytes, place.path());
    let checked = check_folder(place.path());
    match read_folder(place.path()) {
        Ok(cohort) => {
            assert!(checked.passes(), "read, yet with faults");
            written_again(&cohort, format);
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            assert!(!checked.passes(), "refused, yet without faults: {error}");
        }
    }
}

/// Imports packed files without any option.
pub(crate) fn import(format: ImportFormat, bytes: &[u8]) {
    import_files(format, bytes, &TableOptions::default());
}

/// Imports packed files.
fn import_files(format: ImportFormat, bytes: &[u8], options: &TableOptions) {
    let place = folder();
    let source = place.path().join("p1");
    if fs::create_dir(&source).is_err() {
        return;
    }
    unpack_into(bytes, &source);
    match import_with(format, &[source], options) {
        Ok(import) => {
            written_again(&import.cohort, RecordsFormat::Csv);
            for person in &import.report.people {
                for totals in person.totals.iter().flatten() {
                    assert!(totals.closes(), "{totals:?}");
                }
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

const PEOPLE: &str =
    "person_id,weight_kg,therapy,heart_rate_baseline_bpm\na,70,aid,\nb,,unknown,0\n";
const RECORDS: &str = "person_id,time,cgm_mg_dl,basal_u_h,bolus_u,carbs_g,heart_rate_bpm,steps,sleep_efficiency,set_change\n\
     a,2024-03-01T08:00:00,120,0.8,0,0,60,0,0,0\n\
     a,2024-03-01T08:05:00,121.5,0.8,1.5,20,61,10,0.25,1\n\
     b,2024-03-01T08:05:00,99,,,,-5.5,,,\nb,2024-03-01T08:15:00,,,,,,,1,\n";

/// Seeds of `people.csv` with `records.csv`.
pub(crate) fn csv_seeds() -> Vec<Vec<u8>> {
    vec![
        pack(&[("people.csv", PEOPLE), ("records.csv", RECORDS)]),
        pack(&[
            ("people.csv", "person_id\na\n"),
            ("records.csv", "person_id,time,cgm_mg_dl\na,2024-03-01T08:00:00,120\n"),
        ]),
    ]
}

/// Seeds of `people.csv` with `records.parquet`.
pub(crate) fn parquet_seeds() -> Vec<Vec<u8>> {
    let text = folder();
    unpack_into(&csv_seeds()[0], text.path());
    let cohort = read_folder(text.path()).expect("a good seed");
    let place = folder();
    write_folder(&cohort, place.path(), RecordsFormat::Parquet).expect("writable");
    vec![packed(place.path())]
}

/// Seeds of anybody's tables.
pub(crate) fn table_seeds() -> Vec<Vec<u8>> {
    let spreadsheet = fixtures().join("downloads/spreadsheet.csv");
    let text = fs::read(spreadsheet).expect("a fixture");
    vec![
        pack(&[("mine.csv", first_lines(&text, 40))]),
        pack(&[(
            "a.csv",
            "person;time;glucose;bolus\nx;31.12.2024 08:00;5,5;1,5\ny;31.12.2024 08:05;Low;\n",
        )]),
        pack(&[
            ("cgm.csv", "date,clock,cgm\n2024-03-01,08:00,100\n2024-03-01,08:05,101\n"),
            ("bolus.csv", "date,clock,bolus\n2024-03-01,08:03,2\n"),
        ]),
    ]
}

/// Reads anybody's tables: what a guess proposes is then read by that map.
pub(crate) fn read_table(bytes: &[u8]) {
    let place = folder();
    unpack_into(bytes, place.path());
    let mut options = TableOptions::default();
    if let Ok(guess) = guess_table(&[place.path().to_owned()], None)
        && guess.missing.is_empty()
        && !guess.map.is_empty()
    {
        options.add_map(&guess.map).expect("a proposed map is a map");
    }
    import_files(ImportFormat::Table, bytes, &options);
}

/// The parts of a workbook.
fn workbook(name: &str) -> Vec<u8> {
    let file = fs::File::open(fixtures().join(name)).expect("a fixture");
    let mut archive = zip::ZipArchive::new(file).expect("an archive");
    let mut parts = Vec::new();
    for i in 0..archive.len() {
        let mut part = archive.by_index(i).expect("a part");
        let title = part.name().expect("a name").into_owned();
        let mut content = Vec::new();
        part.read_to_end(&mut content).expect("a part");
        // Enough rows for a fuzzer.
        if content.len() > 20_000 {
            let cut = content[..20_000].windows(6).rposition(|end| end == b"</row>");
            content.truncate(cut.map_or(20_000, |at| at + 6));
            content.extend_from_slice(b"</sheetData></worksheet>");
        }
        parts.push((title, content));
    }
    pack(&parts)
}

/// Seeds of the parts of a workbook.
pub(crate) fn workbook_seeds() -> Vec<Vec<u8>> {
    vec![workbook("import/tidepool-xlsx/p1.xlsx"), workbook("downloads/spreadsheet.xlsx")]
}

/// Reads the parts of a workbook as Tidepool's and as anybody's table.
pub(crate) fn read_workbook(bytes: &[u8]) {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let stored =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, content) in unpack(bytes) {
        // A name that came before is refused.
        if archive.start_file(name, stored).is_ok() && archive.write_all(content).is_err() {
            return;
        }
    }
    let Ok(archive) = archive.finish() else { return };
    let packed = pack(&[("p1.xlsx", archive.into_inner())]);
    let madrid = TableOptions { zone: Some("Europe/Madrid".into()), ..Default::default() };
    import_files(ImportFormat::Tidepool, &packed, &madrid);
    read_table(&packed);
}

/// The fixtures of a format, each packed.
pub(crate) fn imports<const N: usize>(names: [&str; N]) -> Vec<Vec<u8>> {
    names.map(|name| packed(&fixtures().join("import").join(name))).into()
}

/// The first lines of the exports in a folder of downloads, each a seed.
pub(crate) fn downloads(name: &str) -> Vec<Vec<u8>> {
    let seed = |path: &PathBuf| {
        let text = fs::read(path).expect("a fixture");
        pack(&[("export.csv", first_lines(&text, 60))])
    };
    files_below(&fixtures().join("downloads").join(name)).iter().map(seed).collect()
}

/// A file of HUPA-UCM.
pub(crate) const HUPA: [(&str, &str); 1] = [(
    "HUPA1.csv",
    "time;glucose;calories;heart_rate;steps;basal_rate;bolus_volume_delivered;carb_input\n\
     2018-06-13T22:45:00;86.0;6.2;65.4;0.0;0.1;6.0;5.0\n\
     2018-06-13T22:50:00;88.0;6.2;65.5;3.0;0.1;0.0;0.0\n",
)];
/// A file of the published T1D simulator.
pub(crate) const T1DSIM: [(&str, &str); 1] = [(
    "example_subject1.csv",
    "hour_of_day,cgm,sleep_efficiency,heart_rate_WRTbaseline,feat_is_weekend,\
     input_insulin_ODEPop,input_meal_carbs_ODEPop\n\
     0,128,0.97,-15.05,0,0.948,0\n0,126,0.97,-15.6,0,0.816,0\n",
)];
/// Each file of the T1D-UOM layout.
pub(crate) const UOM: [(&str, &str); 6] = [
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
