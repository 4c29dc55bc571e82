//! Damaged cohort folders, each given to a stage that reads cohorts, and to `cohort check`.

use std::fs;
use std::path::Path;

use cohort::{CellKind, Cells, ParquetSink};

use super::case::{Cases, repository, text};

const PEOPLE: &str = "person_id,weight_kg,therapy,heart_rate_baseline_bpm\nA,70,aid,60\n";
const HEADER: &str = "person_id,time,cgm_mg_dl,basal_u_h,bolus_u,carbs_g,heart_rate_bpm,steps,\
                      sleep_efficiency\n";

/// What a file of a damaged folder holds.
enum Content {
    Text(String),
    Bytes(Vec<u8>),
    Folder,
    Absent,
}

use Content::{Absent, Bytes, Folder, Text};

/// A damaged folder: its fault, its people, its records, and what the message must hold.
type Damaged = (&'static str, Content, Content, Vec<&'static str>);

pub(super) fn add(cases: &mut Cases) {
    let mut turn = 0;
    for (name, people, records, words) in damaged_people().into_iter().chain(damaged_records()) {
        let folder = cases.place("cohort");
        fs::create_dir(&folder).expect("a folder");
        put(&folder.join("people.csv"), &people);
        put(&folder.join("records.csv"), &records);
        both(cases, &mut turn, name, &folder, &words);
    }
    for (name, bytes, words) in damaged_parquet() {
        let folder = cases.place("cohort");
        fs::create_dir(&folder).expect("a folder");
        put(&folder.join("people.csv"), &Text(PEOPLE.to_owned()));
        fs::write(folder.join("records.parquet"), bytes).expect("writable");
        both(cases, &mut turn, name, &folder, &words);
    }
    let folder = cases.place("cohort");
    fs::create_dir(&folder).expect("a folder");
    put(&folder.join("people.csv"), &Text(PEOPLE.to_owned()));
    put(&folder.join("records.csv"), &Text(rows(3)));
    put(&folder.join("records.parquet"), &Text("PAR1".to_owned()));
    both(cases, &mut turn, "two files of records", &folder, &["remove one"]);
}

/// A stage and `cohort check` on the same folder.
fn both(cases: &mut Cases, turn: &mut usize, name: &str, folder: &Path, words: &[&str]) {
    let folder = text(folder);
    let model = repository("crates/nn-statespace/model/population.safetensors");
    let stages: [&[&str]; 11] = [
        &["diagnose", "--cohort", &folder],
        &["twin", "--cohort", &folder, "--model", &model],
        &["replay", "--cohort", &folder, "--model", &model],
        &["reconcile", "--cohort", &folder],
        &["export", "--cohort", &folder, "--to", "iglu"],
        &["baselines", "--cohort", &folder, "--model", &model],
        &["effect-twins", "--cohort", &folder, "--model", &model],
        &["realism", "--cohort", &folder, "--worlds", "1", "--nulls", "1"],
        &["evidence", "--cohort", &folder, "--worlds", "1", "--nulls", "1"],
        &["blind-check", "--planted", &folder, "--seed", "1"],
        &["pipeline", "--cohort", &folder, "--model", &model],
    ];
    cases.refused(name, stages[*turn % stages.len()], words);
    *turn += 1;
    cases.refused_as_it_is(name, &["cohort", "check", &folder], words);
}

fn put(path: &Path, content: &Content) {
    match content {
        Text(text) => fs::write(path, text).expect("writable"),
        Bytes(bytes) => fs::write(path, bytes).expect("writable"),
        Folder => fs::create_dir(path).expect("writable"),
        Absent => {}
    }
}

/// Records of person A over so many steps.
fn rows(steps: usize) -> String {
    let mut text = HEADER.to_owned();
    for step in 0..steps {
        text += &row(step, "120", "0", "0");
    }
    text
}

fn row(step: usize, cgm: &str, bolus: &str, carbs: &str) -> String {
    let (hour, minute) = (step / 12, step % 12 * 5);
    format!("A,2024-01-01T{hour:02}:{minute:02}:00,{cgm},0.8,{bolus},{carbs},70,0,0\n")
}

/// The records with one more row.
fn and(row: &str) -> Content {
    Text(format!("{}{row}\n", rows(3)))
}

fn utf_16(text: &str) -> Content {
    let units = text.encode_utf16().flat_map(u16::to_le_bytes);
    Bytes([0xFF, 0xFE].into_iter().chain(units).collect())
}

fn person(id: &str) -> Content {
    Text(PEOPLE.replace("A,70", &format!("{id},70")))
}

fn damaged_people() -> Vec<Damaged> {
    let good = || Text(rows(3));
    let edited = |from: &str, to: &str| Text(PEOPLE.replace(from, to));
    let id = vec!["people.csv", "row 2", "person_id", "use letters, digits"];
    let in_row = |column| vec!["people.csv", "row 2", column];
    vec![
        ("people: absent", Absent, good(), vec!["people.csv"]),
        ("people: a folder", Folder, good(), vec!["people.csv", "folder"]),
        ("people: empty file", Text(String::new()), good(), vec!["people.csv", "no data row"]),
        ("people: header only", edited("A,70,aid,60\n", ""), good(), vec!["people.csv"]),
        ("people: UTF-16", utf_16(PEOPLE), good(), vec!["people.csv", "UTF-8"]),
        (
            "people: Latin-1",
            Bytes(
                PEOPLE
                    .replace("A,", "\u{1},")
                    .bytes()
                    .map(|b| b.max(2))
                    .map(|b| if b == 2 { 0xE9 } else { b })
                    .collect(),
            ),
            good(),
            vec!["people.csv", "row 2", "UTF-8"],
        ),
        ("people: NUL bytes", edited("aid", "a\0d"), good(), in_row("zero byte")),
        (
            "people: truncated",
            edited(",aid,60\n", ""),
            good(),
            vec!["people.csv", "row 2", "cut off"],
        ),
        (
            "people: open quote",
            edited("aid", "\"aid"),
            good(),
            vec!["people.csv", "row 2", "quote"],
        ),
        (
            "people: other columns",
            edited("person_id", "patient"),
            good(),
            vec!["people.csv", "person_id"],
        ),
        (
            "people: misspelt column",
            edited("weight_kg", "wieght_kg"),
            good(),
            vec!["did you mean 'weight_kg'"],
        ),
        (
            "people: column twice",
            edited("weight_kg", "person_id"),
            good(),
            vec!["two columns named"],
        ),
        (
            "people: listed twice",
            Text(format!("{PEOPLE}A,70,aid,60\n")),
            good(),
            vec!["row 3", "listed twice"],
        ),
        (
            "people: nobody recorded",
            Text(format!("{PEOPLE}B,70,aid,60\n")),
            good(),
            vec!["'B'", "records.csv"],
        ),
        ("people: weight in text", edited("70", "heavy"), good(), in_row("weight_kg")),
        ("people: weight NaN", edited("70", "NaN"), good(), in_row("weight_kg")),
        ("people: weight infinite", edited("70", "1e999"), good(), in_row("weight_kg")),
        ("people: weight negative", edited("70", "-70"), good(), in_row("weight_kg")),
        ("people: weight in g", edited("70", "70000"), good(), in_row("weight_kg")),
        ("people: therapy unknown", edited("aid", "magic"), good(), in_row("therapy")),
        (
            "people: heart rate formula",
            edited("60", "=6*10"),
            good(),
            in_row("heart_rate_baseline_bpm"),
        ),
        ("id: empty", person(""), good(), id.clone()),
        ("id: leaves the folder", person("../x"), good(), id.clone()),
        ("id: a path", person("a/b"), good(), id.clone()),
        ("id: a path of Windows", person("a\\b"), good(), id.clone()),
        ("id: a device of Windows", person("CON"), good(), in_row("person_id")),
        ("id: a device with an ending", person("nul.txt"), good(), in_row("person_id")),
        ("id: a dot", person("."), good(), id.clone()),
        ("id: two dots", person(".."), good(), id.clone()),
        ("id: very long", person(&"x".repeat(300)), good(), in_row("person_id")),
        ("id: control characters", person("A\u{7}B"), good(), id.clone()),
        ("id: turns the text around", person("A\u{202E}B"), good(), id.clone()),
        ("id: a formula", person("=1+1"), good(), id.clone()),
        ("id: begins like an option", person("-rf"), good(), in_row("person_id")),
    ]
}

fn damaged_records() -> Vec<Damaged> {
    let good = || Text(PEOPLE.to_owned());
    let with = |from: &str, to: &str| Text(rows(3).replacen(from, to, 1));
    let cell = |column| vec!["records.csv", "row 5", column];
    let long = "1".repeat(10 << 20);
    let wide = |n: usize| {
        vec!["c"; n].iter().enumerate().map(|(i, c)| format!(",{c}{i}")).collect::<String>()
    };
    vec![
        ("records: absent", good(), Absent, vec!["records.csv"]),
        ("records: a folder", good(), Folder, vec!["records.csv", "folder"]),
        ("records: empty file", good(), Text(String::new()), vec!["records.csv", "no data row"]),
        (
            "records: header only",
            good(),
            Text(HEADER.to_owned()),
            vec!["records.csv", "no data row"],
        ),
        ("records: only NUL", good(), Bytes(vec![0; 5000]), vec!["records.csv"]),
        (
            "records: garbage",
            good(),
            Bytes((0..5000).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect()),
            vec!["records.csv", "row 1"],
        ),
        ("records: UTF-16", good(), utf_16(&rows(3)), vec!["records.csv", "UTF-8"]),
        (
            "records: truncated",
            good(),
            Text(rows(3)[..rows(3).len() - 12].to_owned()),
            vec!["records.csv", "row 4", "cut off"],
        ),
        ("records: semicolons", good(), Text(rows(3).replace(',', ";")), vec!["records.csv"]),
        (
            "records: very long line",
            good(),
            and(&format!("A,2024-01-01T00:15:00,{long},0,0,0,70,0,0")),
            vec!["records.csv", "row 5"],
        ),
        ("records: one line of 64 MB", good(), Text("x".repeat(64 << 20)), vec!["records.csv"]),
        (
            "records: 200,000 columns",
            good(),
            Text(rows(3).replacen(
                ",sleep_efficiency",
                &format!(",sleep_efficiency{}", wide(200_000)),
                1,
            )),
            vec!["records.csv", "columns"],
        ),
        (
            "records: 200,000 columns and rows",
            good(),
            Text(format!("time{}\nx{}\n", wide(200_000), ",1".repeat(200_000))),
            vec!["records.csv", "columns"],
        ),
        (
            "records: no glucose",
            good(),
            with("cgm_mg_dl", "sugar"),
            vec!["records.csv", "cgm_mg_dl", "found"],
        ),
        (
            "records: misspelt column",
            good(),
            with("carbs_g", "crabs_g"),
            vec!["did you mean 'carbs_g'"],
        ),
        (
            "records: column twice",
            good(),
            with("carbs_g", "bolus_u"),
            vec!["two columns named 'bolus_u'"],
        ),
        (
            "records: open quote",
            good(),
            and("A,\"2024-01-01T00:15:00,120,0,0,0,70,0,0"),
            vec!["records.csv", "row 5", "quote"],
        ),
        (
            "records: a row with a stray separator",
            good(),
            and("A,2024-01-01T00:15:00,120,0,8,0,0,70,0,0"),
            vec!["records.csv", "row 5", "stray separator"],
        ),
        (
            "records: unknown person",
            good(),
            and("B,2024-01-01T00:15:00,120,0,0,0,70,0,0"),
            vec!["row 5", "'B'", "people.csv"],
        ),
        (
            "records: text in numbers",
            good(),
            and("A,2024-01-01T00:15:00,high,0,0,0,70,0,0"),
            cell("cgm_mg_dl"),
        ),
        (
            "records: decimal comma",
            good(),
            and("A,2024-01-01T00:15:00,\"6,7\",0,0,0,70,0,0"),
            cell("cgm_mg_dl"),
        ),
        ("records: NaN", good(), and("A,2024-01-01T00:15:00,NaN,0,0,0,70,0,0"), cell("cgm_mg_dl")),
        (
            "records: infinite",
            good(),
            and("A,2024-01-01T00:15:00,120,inf,0,0,70,0,0"),
            cell("basal_u_h"),
        ),
        (
            "records: overflow",
            good(),
            and("A,2024-01-01T00:15:00,120,1e400,0,0,70,0,0"),
            cell("basal_u_h"),
        ),
        (
            "records: formula",
            good(),
            and("A,2024-01-01T00:15:00,=120+1,0,0,0,70,0,0"),
            cell("cgm_mg_dl"),
        ),
        (
            "records: command of a spreadsheet",
            good(),
            and("A,2024-01-01T00:15:00,120,0,@SUM(1),0,70,0,0"),
            cell("bolus_u"),
        ),
        (
            "records: NUL in a number",
            good(),
            and("A,2024-01-01T00:15:00,12\u{0}0,0,0,0,70,0,0"),
            cell("zero byte"),
        ),
        (
            "records: control characters",
            good(),
            and("A,2024-01-01T00:15:00,\u{1b}[31m120,0,0,0,70,0,0"),
            cell("cgm_mg_dl"),
        ),
        (
            "records: negative bolus",
            good(),
            and("A,2024-01-01T00:15:00,120,0,-1,0,70,0,0"),
            cell("bolus_u"),
        ),
        (
            "records: negative carbohydrate",
            good(),
            and("A,2024-01-01T00:15:00,120,0,0,-20,70,0,0"),
            cell("carbs_g"),
        ),
        (
            "records: carbohydrate in mg",
            good(),
            and("A,2024-01-01T00:15:00,120,0,0,60000,70,0,0"),
            cell("carbs_g"),
        ),
        (
            "records: basal of 1e9",
            good(),
            and("A,2024-01-01T00:15:00,120,1e9,0,0,70,0,0"),
            cell("basal_u_h"),
        ),
        (
            "records: heart rate of 900",
            good(),
            and("A,2024-01-01T00:15:00,120,0,0,0,900,0,0"),
            cell("heart_rate_bpm"),
        ),
        (
            "records: sleep of 95 %",
            good(),
            and("A,2024-01-01T00:15:00,120,0,0,0,70,0,95"),
            cell("sleep_efficiency"),
        ),
        (
            "records: mmol/L",
            good(),
            Text(rows(3).replace(",120,", ",6.7,")),
            vec!["records.csv", "cgm_mg_dl", "mmol/L"],
        ),
        (
            "records: row twice",
            good(),
            and(row(2, "120", "0", "0").trim()),
            vec!["row 5", "two rows"],
        ),
        (
            "records: out of order",
            good(),
            Text(format!(
                "{HEADER}{}{}{}",
                row(1, "120", "0", "0"),
                row(2, "120", "0", "0"),
                row(0, "120", "0", "0")
            )),
            vec!["row 4", "sort the rows"],
        ),
        (
            "records: off the grid",
            good(),
            and("A,2024-01-01T00:17:00,120,0,0,0,70,0,0"),
            vec!["row 5", "5-minute grid"],
        ),
        (
            "records: with seconds",
            good(),
            and("A,2024-01-01T00:15:59,120,0,0,0,70,0,0"),
            vec!["row 5", "5-minute grid"],
        ),
        (
            "records: day-first date",
            good(),
            and("A,31/12/2024 00:15,120,0,0,0,70,0,0"),
            cell("time"),
        ),
        ("records: no time", good(), and("A,,120,0,0,0,70,0,0"), cell("time")),
        (
            "records: 31 February",
            good(),
            and("A,2024-02-31T00:15:00,120,0,0,0,70,0,0"),
            cell("time"),
        ),
        (
            "records: with a zone",
            good(),
            and("A,2024-01-01T00:15:00Z,120,0,0,0,70,0,0"),
            cell("time"),
        ),
        (
            "records: year 1",
            good(),
            with("2024", "0001"),
            vec!["records.csv", "row 2", "years 1900"],
        ),
        (
            "records: year 99999",
            good(),
            with("2024", "99999"),
            vec!["records.csv", "row 2", "time"],
        ),
        (
            "records: a row 170 years on",
            good(),
            and("A,2194-01-01T00:15:00,120,0,0,0,70,0,0"),
            vec!["row 5", "time is probably wrong"],
        ),
    ]
}

fn damaged_parquet() -> Vec<(&'static str, Vec<u8>, Vec<&'static str>)> {
    let good = fs::read(repository("fixtures/embedded/cohort/records.parquet")).expect("there");
    let flipped = |at: usize| {
        let mut bytes = good.clone();
        bytes[at..at + 64].fill(0x55);
        bytes
    };
    let footer = good.len() - 400;
    // In the place of the byte that ends the footer: field 100, a list of two billion truth values, and the end.
    let list = [0x09, 0xc8, 0x01, 0xf1, 0xff, 0xff, 0xff, 0xff, 0x07, 0];
    let (data, tail) = good.split_at(good.len() - 8);
    let length = u32::from_le_bytes(tail[..4].try_into().expect("four bytes"));
    let length = (length + list.len() as u32 - 1).to_le_bytes();
    let billions = [&data[..data.len() - 1], &list, &length, b"PAR1"].concat();
    vec![
        ("Parquet: a list of billions", billions, vec!["records.parquet", "footer is damaged"]),
        ("Parquet: empty", Vec::new(), vec!["records.parquet", "cut off"]),
        ("Parquet: only marks", b"PAR1PAR1".to_vec(), vec!["records.parquet", "cut off"]),
        ("Parquet: text", rows(3).into_bytes(), vec!["records.parquet"]),
        (
            "Parquet: first half",
            good[..good.len() / 2].to_vec(),
            vec!["records.parquet", "cut off"],
        ),
        (
            "Parquet: second half",
            good[good.len() / 2..].to_vec(),
            vec!["records.parquet", "cut off"],
        ),
        ("Parquet: no middle", [&good[..1000], &good[footer..]].concat(), vec!["records.parquet"]),
        ("Parquet: damaged footer", flipped(footer), vec!["records.parquet"]),
        (
            "Parquet: length of the footer",
            [&good[..good.len() - 8], &[0xFF; 4], b"PAR1"].concat(),
            vec!["records.parquet"],
        ),
        ("Parquet: damaged page", flipped(40), vec!["records.parquet"]),
        ("Parquet: other columns", table(3, 1), vec!["records.parquet", "person_id"]),
        ("Parquet: 1e8 rows", table(1 << 20, 100), vec!["records.parquet", "rows, more than"]),
        ("Parquet: 5,000 columns", wide(5000), vec!["records.parquet", "columns, more than"]),
    ]
}

/// A table of steps without a number, in so many pieces: a few bytes a piece.
fn table(rows: usize, pieces: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let columns = [("colour", CellKind::Number)];
    let mut sink = ParquetSink::new("x", &mut bytes, &columns).expect("a sink");
    for _ in 0..pieces {
        sink.write(vec![Cells::Numbers(vec![None; rows])]).expect("written");
    }
    sink.finish().expect("written");
    bytes
}

fn wide(columns: usize) -> Vec<u8> {
    let names: Vec<String> = (0..columns).map(|i| format!("c{i}")).collect();
    let columns: Vec<(&str, CellKind)> =
        names.iter().map(|n| (n.as_str(), CellKind::Integer)).collect();
    let mut bytes = Vec::new();
    let mut sink = ParquetSink::new("x", &mut bytes, &columns).expect("a sink");
    sink.write(vec![Cells::Integers(vec![1]); columns.len()]).expect("written");
    sink.finish().expect("written");
    bytes
}
