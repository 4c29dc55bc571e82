//! Damaged files of every format that is imported, and files of another study.

use std::fs;
use std::path::{Path, PathBuf};

use super::case::{Cases, repository, text};

/// A format, its example, and whether the example is a folder.
const FORMATS: [(&str, &str); 10] = [
    ("dexcom", "fixtures/downloads/dexcom"),
    ("libre", "fixtures/downloads/libre"),
    ("nightscout", "fixtures/import/nightscout"),
    ("tidepool", "fixtures/import/tidepool"),
    ("t1dexi", "fixtures/import/t1dexi"),
    ("metabonet", "fixtures/import/metabonet"),
    ("babelbetes", "fixtures/import/babelbetes"),
    ("ohio", "fixtures/import/ohio"),
    ("simglucose", "fixtures/import/simglucose"),
    ("replaybg", "fixtures/import/replaybg"),
];
/// Formats without an example here.
const WITHOUT_EXAMPLE: [(&str, &str); 3] = [
    ("hupa-ucm", "HUPA0001P.csv"),
    ("t1d-uom", "Glucose Data"),
    ("t1dsim", "example_subjectX.csv"),
];

/// What is done to the bytes of a file.
type Damage = (&'static str, fn(&[u8]) -> Vec<u8>);

const DAMAGES: [Damage; 5] = [
    ("empty files", |_| Vec::new()),
    ("garbage", |bytes| {
        (0..bytes.len() as u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect()
    }),
    ("only NUL", |bytes| vec![0; bytes.len()]),
    ("cut in the middle of a line", |bytes| bytes[..(bytes.len() / 3) | 1].to_vec()),
    ("UTF-16", |bytes| {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let units = text.encode_utf16().flat_map(u16::to_le_bytes);
        [0xFF, 0xFE].into_iter().chain(units).collect()
    }),
];

pub(super) fn add(cases: &mut Cases) {
    for (format, example) in FORMATS {
        let example = PathBuf::from(repository(example));
        for (name, damage) in DAMAGES {
            let copy = cases.place("study");
            let file = damaged_copy(&example, &copy, damage);
            // A CSV that ends within a line of a log is found; what else is cut off may be whole.
            // Text in UTF-16 is read there.
            if (name.starts_with("cut") || name == "UTF-16") && matches!(format, "dexcom" | "libre")
            {
                continue;
            }
            let typed = ["import", "--from", format, &text(&copy)];
            cases.refused(&format!("{format}: {name}"), &typed, &[format, &file]);
        }
    }
    for format in FORMATS.iter().chain(&WITHOUT_EXAMPLE).map(|(format, _)| *format) {
        let other =
            if format == "ohio" { "fixtures/import/t1dexi" } else { "fixtures/import/ohio" };
        let typed = ["import", "--from", format, &repository(other)];
        cases.refused(&format!("{format}: the folder of another study"), &typed, &[format]);
        let typed = ["import", "--from", format, &repository("fixtures/golden/meals.csv")];
        cases.refused(
            &format!("{format}: a file of another study"),
            &typed,
            &[format, "meals.csv"],
        );
        let typed = ["import", "--from", format, "nowhere"];
        cases.refused(&format!("{format}: absent"), &typed, &["nothing at 'nowhere'"]);
        let empty = cases.place("empty");
        fs::create_dir(&empty).expect("writable");
        let typed = ["import", "--from", format, &text(&empty)];
        cases.refused(&format!("{format}: an empty folder"), &typed, &[format, "empty"]);
    }
    for (format, file) in WITHOUT_EXAMPLE {
        let file = cases.file(file, "");
        let folder = text(Path::new(&file).parent().expect("a folder"));
        let typed = ["import", "--from", format, &folder];
        cases.refused(&format!("{format}: empty files"), &typed, &[format]);
    }
    tables(cases);
}

/// Copies a file or folder with every file damaged; the name of a damaged file.
fn damaged_copy(from: &Path, to: &Path, damage: fn(&[u8]) -> Vec<u8>) -> String {
    if from.is_file() {
        fs::write(to, damage(&fs::read(from).expect("readable"))).expect("writable");
        return String::new();
    }
    fs::create_dir_all(to).expect("writable");
    let mut entries: Vec<PathBuf> = fs::read_dir(from)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    entries.sort();
    for entry in entries {
        damaged_copy(&entry, &to.join(entry.file_name().expect("a name")), damage);
    }
    String::new()
}

/// Anybody's tables.
fn tables(cases: &mut Cases) {
    let spreadsheet = repository("fixtures/downloads/spreadsheet.csv");
    let map =
        "person=Código,time=Fecha y hora,glucose=Glucosa,basal=Basal (U),bolus=Bolo,carbs=Hidratos";
    let import = ["import", "--from", "table"];
    let mapped = |more: &[&'static str]| {
        let words: Vec<&str> = [&import[..], &[spreadsheet.as_str(), "--map"], more].concat();
        words.into_iter().map(str::to_owned).collect::<Vec<String>>()
    };
    let mut say = |name: &str, typed: Vec<String>, words: &[&str]| {
        let typed: Vec<&str> = typed.iter().map(String::as_str).collect();
        cases.refused(&format!("table: {name}"), &typed, words);
    };
    say("a column that is not there", mapped(&["time=Zeit,glucose=Glucosa"]), &["Zeit", "found"]);
    say("an unknown role", mapped(&["time=Fecha y hora,sugar=Glucosa"]), &["sugar"]);
    say("no time", mapped(&["glucose=Glucosa"]), &["time"]);
    say("a map that is none", mapped(&["nonsense"]), &["nonsense"]);
    say("an empty map", mapped(&["="]), &["--map"]);
    say("a unit that is none", mapped(&[map, "--unit", "glucose=stone"]), &["stone"]);
    say("a unit of nothing", mapped(&[map, "--unit", "colour=mg/dL"]), &["colour"]);
    say(
        "a zone that is none",
        mapped(&[map, "--unit", "glucose=mmol/L", "--zone", "Moon/Sea"]),
        &["Moon/Sea"],
    );
    say("a map without an end", mapped(&["/dev/zero"]), &["/dev/zero"]);
    say("a folder for a map", mapped(&["/"]), &["--map /"]);
    for (name, toml, words) in [
        ("a TOML map that is truncated", "[columns\n", &["map.toml", "line 1"][..]),
        ("a TOML map with an unknown key", "colour = 1\n", &["map.toml", "colour"]),
        ("a TOML map of another type", "columns = 3\n", &["map.toml"]),
    ] {
        let map = cases.file("map.toml", toml);
        let typed = ["import", "--from", "table", &spreadsheet, "--map", &map];
        cases.refused(&format!("table: {name}"), &typed, words);
    }
    let header = "Time;Glucose\n";
    for (name, table, words) in [
        (
            "text in numbers",
            format!("{header}2024-01-01 00:00;many\n"),
            &["my.csv", "row 2", "Glucose"][..],
        ),
        ("no rows", header.to_owned(), &["my.csv", "no data row"]),
        ("a formula", format!("{header}2024-01-01 00:00;=A1\n"), &["my.csv", "row 2", "Glucose"]),
        ("times that are none", format!("{header}yesterday;120\n"), &["my.csv", "row 2", "Time"]),
        (
            "years far apart",
            format!("{header}1950-01-01 00:00;120\n2190-01-01 00:00;120\n"),
            &["my.csv"],
        ),
        ("glucose of 1e300", format!("{header}2024-01-01 00:00;1e300\n"), &["my.csv"]),
        ("a line of 64 MB", "x".repeat(64 << 20), &["my.csv"]),
        ("a row that is cut off", format!("{header}2024-01-01 00:00\n"), &["my.csv", "row 2"]),
        (
            "200,000 columns",
            format!("Time{}\n2024-01-01 00:00{}\n", ";c".repeat(200_000), ";1".repeat(200_000)),
            &["my.csv"],
        ),
    ] {
        let file = cases.file("my.csv", table);
        let typed = ["import", "--from", "table", &file, "--map", "time=Time,glucose=Glucose"];
        cases.refused(&format!("table: {name}"), &typed, words);
    }
    let sparse: String = (0..300)
        .map(|person| format!("{person};2004-01-01 00:00;120\n{person};2023-01-01 00:00;121\n"))
        .collect();
    let file = cases.file("my.csv", format!("Who;Time;Glucose\n{sparse}"));
    cases.refused(
        "table: two readings in twenty years, of 300 people",
        &["import", "--from", "table", &file, "--map", "person=Who,time=Time,glucose=Glucose"],
        &["my.csv", "Glucose", "person '0'", "spans 6940 days"],
    );
    let empty = cases.file("empty.csv", "");
    cases.refused_as_it_is(
        "table: nothing to guess",
        &["import", "--from", "table", &empty, "--guess"],
        &["empty.csv"],
    );
    cases.refused_as_it_is(
        "table: a guess about a known format",
        &["import", "--from", "dexcom", &empty, "--guess"],
        &["--guess"],
    );
    cases.refused(
        "table: without an end",
        &["import", "--from", "table", "/dev/zero", "--map", "time=a,glucose=b"],
        &["/dev/zero"],
    );
    for format in ["dexcom", "libre", "tidepool", "ohio", "replaybg", "metabonet", "t1dsim"] {
        let typed = ["import", "--from", format, "/dev/zero"];
        cases.refused(&format!("{format}: without an end"), &typed, &["/dev/zero"]);
    }
}
