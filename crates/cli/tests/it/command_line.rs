//! The command line as a person meets it: exit statuses, messages, and outputs complete or absent.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn xtask(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn text(path: &Path) -> &str {
    path.to_str().expect("temporary paths are UTF-8")
}

/// Runs a command that must be refused with status 1 and one message that holds all of `words`,
/// and must leave nothing at `out`.
fn refused(arguments: &[&str], out: &Path, words: &[&str]) {
    let out_text = text(out).to_owned();
    let all: Vec<&str> = arguments.iter().copied().chain(["--out", &out_text, "-q"]).collect();
    let output = xtask(&all);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
    assert!(message.starts_with("error: "), "{message}");
    assert!(!message.contains("panicked"), "{message}");
    for word in words {
        assert!(message.contains(word), "'{word}' is not in: {message}");
    }
    assert!(!out.exists(), "{arguments:?} left something behind");
    let parent = out.parent().expect("a parent");
    let left: Vec<PathBuf> = fs::read_dir(parent)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| {
            path.file_name().is_some_and(|n| n.to_string_lossy().starts_with(".building"))
        })
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn embedded() -> String {
    text(&workspace().join("fixtures/embedded/cohort")).to_owned()
}

const PEOPLE: &str = "person_id,weight_kg,therapy,heart_rate_baseline_bpm\nA,70,aid,60\n";
const RECORDS_HEADER: &str = "person_id,time,cgm_mg_dl,basal_u_h,bolus_u,carbs_g,heart_rate_bpm,\
                              steps,sleep_efficiency\n";

/// A cohort folder with these data rows.
fn cohort(folder: &Path, rows: &str) {
    fs::create_dir_all(folder).expect("a folder");
    fs::write(folder.join("people.csv"), PEOPLE).expect("writable");
    fs::write(folder.join("records.csv"), format!("{RECORDS_HEADER}{rows}")).expect("writable");
}

#[test]
fn wrong_usage_ends_with_status_2() {
    for arguments in [
        &["no-such-command"][..],
        &["simulate"],
        &["pipeline", "--profile", "slow"],
        &["replay", "--cohort", "x", "--model", "y", "--initial", "somewhere"],
        &["verify", "--model", "m", "--limit", "soon"],
        &["verify", "--model", "m", "--twin", "t", "--cohort", "c", "--widen", "0.1"],
        &["verify", "--model", "m", "--twin", "t", "--cohort", "c", "--delta", "1"],
        &["verify", "--model", "m", "--twin", "t", "--cohort", "c", "--milp", "none"],
    ] {
        assert_eq!(xtask(arguments).status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn every_command_has_an_example_in_its_help() {
    let help = String::from_utf8(xtask(&["--help"]).stdout).expect("UTF-8");
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| line.starts_with("  "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|command| *command != "help")
        .collect();
    assert!(commands.len() >= 12, "{commands:?}");
    for command in commands {
        let output = xtask(&[command, "--help"]);
        let help = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(help.contains(&format!("t1d-twins {command}")), "{command}: {help}");
        assert!(help.contains("Example"), "{command}: {help}");
    }
}

#[test]
fn missing_and_wrong_inputs_are_refused_in_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let out = at("out");
    fs::create_dir(at("empty")).expect("a folder");
    fs::write(at("file"), "not a model").expect("writable");

    refused(&["diagnose", "--cohort", text(&at("nowhere"))], &out, &["nowhere"]);
    refused(&["diagnose", "--cohort", text(&at("empty"))], &out, &["people.csv"]);
    refused(&["diagnose", "--cohort", &embedded(), "--model", "x.safetensors"], &out, &["ode"]);
    refused(&["import", "--from", "hupa-ucm", text(&at("nowhere"))], &out, &["nowhere"]);
    refused(&["import", "--from", "hupa-ucm", text(&at("empty"))], &out, &["HUPA"]);
    refused(&["import", "--from", "t1d-uom", text(&at("empty"))], &out, &["Glucose Data"]);
    refused(&["import-model", "--from", "t1dsim", text(&at("empty"))], &out, &["population_model"]);
    refused(
        &["twin", "--cohort", &embedded(), "--model", text(&at("file"))],
        &out,
        &["not a population model"],
    );
    refused(&["replay", "--cohort", &embedded(), "--model", text(&at("empty"))], &out, &["folder"]);
    refused(
        &["evaluate", "--cohort", &embedded(), "--twins", text(&at("empty"))],
        &out,
        &["manifest"],
    );
    refused(&["verify", "--model", text(&at("file")), "--limit", "0"], &out, &["--limit"]);
    refused(&["verify", "--model", text(&at("file"))], &out, &["not a population model"]);
    let model = workspace().join("crates/nn-statespace/model/population.safetensors");
    fs::copy(&model, at("alone.safetensors")).expect("copied");
    let alone = at("alone.safetensors");
    refused(&["verify", "--model", text(&alone)], &out, &["region.json"]);

    let report = xtask(&["report", text(&at("empty"))]);
    assert_eq!(report.status.code(), Some(1));
}

#[test]
fn faulty_cohorts_name_row_and_column() {
    let folder = tempfile::tempdir().expect("a folder");
    let row = |time: &str, cgm: &str, bolus: &str| format!("A,{time},{cgm},0.8,{bolus},0,70,0,0\n");
    let first = row("2024-01-01T00:00:00", "120", "0");
    let cases: [(&str, String, &[&str]); 5] = [
        ("mmol", first.replace("120", "6.7"), &["mmol/L"]),
        (
            "dose",
            format!("{first}{}", row("2024-01-01T00:05:00", "121", "-1")),
            &["records.csv", "row 3", "bolus_u"],
        ),
        (
            "text",
            format!("{first}{}", row("2024-01-01T00:05:00", "high", "0")),
            &["row 3", "cgm_mg_dl", "high"],
        ),
        ("grid", format!("{first}{}", row("2024-01-01T00:07:00", "121", "0")), &["row 3", "time"]),
        ("twice", format!("{first}{first}"), &["row 3"]),
    ];
    for (name, rows, words) in cases {
        let path = folder.path().join(name);
        cohort(&path, &rows);
        refused(&["diagnose", "--cohort", text(&path)], &folder.path().join("out"), words);
    }
}

#[test]
fn a_folder_that_is_not_ours_is_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("thesis.txt"), "years of work").expect("writable");
    let output = xtask(&["diagnose", "--cohort", &embedded(), "--out", text(folder.path()), "-q"]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(
        fs::read_to_string(folder.path().join("thesis.txt")).expect("still there"),
        "years of work"
    );
}

#[test]
fn an_input_is_never_replaced_by_the_output() {
    let folder = tempfile::tempdir().expect("a folder");
    let copy = folder.path().join("cohort");
    fs::create_dir(&copy).expect("a folder");
    for file in ["people.csv", "records.parquet"] {
        fs::copy(Path::new(&embedded()).join(file), copy.join(file)).expect("copied");
    }
    let first = folder.path().join("first");
    let arguments = ["diagnose", "--cohort", text(&copy), "--out", text(&first), "-q"];
    assert!(xtask(&arguments).status.success());
    // The cohort folder now carries a manifest of the right command, as if it were an output.
    fs::copy(first.join("manifest.json"), copy.join("manifest.json")).expect("copied");
    let output = xtask(&["diagnose", "--cohort", text(&copy), "--out", text(&copy), "-q"]);
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("an input of this run"), "{message}");
    assert!(copy.join("records.parquet").is_file());

    // Another command's output is left alone as well.
    let output = xtask(&["import", "--from", "t1dsim", text(&copy), "--out", text(&first), "-q"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(first.join("diagnosis.json").is_file());
}

#[test]
fn numbers_out_of_bounds_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let golden = workspace().join("fixtures/golden");
    let (patients, meals) = (golden.join("patients.csv"), golden.join("meals.csv"));
    let simulate = ["simulate", "--patients", text(&patients), "--meals", text(&meals)];
    refused(&[&simulate[..], &["--days", "1000000"]].concat(), &out, &["--days"]);
    refused(&[&simulate[..], &["--days", "0"]].concat(), &out, &["--days"]);
    refused(&[&simulate[..], &["--threads", "100000"]].concat(), &out, &["--threads"]);
    let model = folder.path().join("m");
    refused(&["verify", "--model", text(&model), "--limit", "1e300"], &out, &["--limit"]);
}

#[test]
fn a_diagnosis_is_the_same_for_any_number_of_threads_and_ends_in_a_report() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |threads: &str| {
        let out = folder.path().join(threads);
        let arguments =
            ["diagnose", "--cohort", &embedded(), "--threads", threads, "--out", text(&out), "-q"];
        let output = xtask(&arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        out
    };
    let (one, three) = (run("1"), run("3"));
    let read = |folder: &Path, name: &str| fs::read(folder.join(name)).expect("written");
    assert_eq!(read(&one, "diagnosis.json"), read(&three, "diagnosis.json"));
    let diagnosis: serde_json::Value =
        serde_json::from_slice(&read(&one, "diagnosis.json")).expect("JSON");
    assert_eq!(diagnosis["schema"], "diagnosis/3");
    assert!(diagnosis["where"].as_array().is_some_and(|cells| !cells.is_empty()));
    let html = String::from_utf8(read(&one, "report.html")).expect("UTF-8");
    assert!(html.contains("Not a medical device"));
    let manifest: serde_json::Value =
        serde_json::from_slice(&read(&one, "manifest.json")).expect("JSON");
    assert_eq!(manifest["inputs"].as_array().map(Vec::len), Some(2));
}

#[test]
fn damaged_weights_are_refused() {
    let name = "damaged_weights_are_refused";
    let Some(published) = reference_data::find("t1dsim_ai", name) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let copy = folder.path().join("model");
    fs::create_dir(&copy).expect("a folder");
    for file in ["population_model_05022024_epoch_15.pt", "scaler_states.pkl", "scaler_inputs.pkl"]
    {
        fs::copy(published.join(file), copy.join(file)).expect("copied");
    }
    let weights = copy.join("population_model_05022024_epoch_15.pt");
    let whole = fs::read(&weights).expect("readable");
    fs::write(&weights, &whole[..whole.len() / 2]).expect("writable");
    let out = folder.path().join("out");
    refused(&["import-model", "--from", "t1dsim", text(&copy)], &out, &["published model"]);

    fs::write(&weights, &whole).expect("writable");
    let good = folder.path().join("good");
    let output =
        xtask(&["import-model", "--from", "t1dsim", text(&copy), "--out", text(&good), "-q"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let model = good.join("population.safetensors");
    let mut bytes = fs::read(&model).expect("readable");
    let last = bytes.len() - 8;
    bytes[last..].copy_from_slice(&f64::NAN.to_le_bytes());
    fs::write(&model, bytes).expect("writable");
    let arguments = ["replay", "--cohort", &embedded(), "--model", text(&model)];
    refused(&arguments, &out, &["not a finite number"]);
}

#[test]
fn published_models_replay_the_published_traces() {
    let name = "published_models_replay_the_published_traces";
    let Some(published) = reference_data::find("t1dsim_ai", name) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let run = |arguments: &[&str], out: &str| {
        let out = text(&at(out)).to_owned();
        let all: Vec<&str> = arguments.iter().copied().chain(["--out", &out, "-q"]).collect();
        let output = xtask(&all);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    run(&["import-model", "--from", "t1dsim", text(&published)], "population");
    run(&["import-model", "--from", "t1dsim", text(&published.join("Model0826"))], "twin");
    let day = published.join("example_subjectX.csv");
    run(&["import", "--from", "t1dsim", text(&day)], "day");
    let model = at("population").join("population.safetensors");
    let twin = at("twin").join("twin.safetensors");
    let start = format!("table:{}", text(&published.join("initSteadyStates.csv")));
    let cohort = at("day");
    let common =
        ["replay", "--cohort", text(&cohort), "--model", text(&model), "--initial", &start];
    run(&common, "trace_population");
    run(&[&common[..], &["--twin", text(&twin)]].concat(), "trace_twin_0826");
    for trace in ["trace_population", "trace_twin_0826"] {
        let ours = column(&at(trace).join("traces.csv"), "Q1");
        let theirs = column(&published.join(format!("{trace}.csv")), "Q1");
        assert_eq!(ours.len(), theirs.len());
        let largest = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Their traces are printed with nine significant digits: half of 1e-6 mg/dL.
        assert!(largest < 6e-7, "{trace}: {largest} mg/dL");
    }
}

#[test]
fn simulate_reproduces_the_published_virtual_patients() {
    let name = "simulate_reproduces_the_published_virtual_patients";
    let Some(vpp) = reference_data::find("t1d_vpp", name) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let file = |name: &str| text(&vpp.join(name)).to_owned();
    let output = xtask(&[
        "simulate",
        "--patients",
        &file("patients.csv"),
        "--meals",
        &file("meals.csv"),
        "--initial",
        &file("initial_states.csv"),
        "--out",
        text(&out),
        "-q",
    ]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let theirs = trace_rows(&vpp.join("traces.csv"));
    let ours = trace_rows(&out.join("traces.csv"));
    assert!(theirs.len() > 10_000);
    for (key, expected) in &theirs {
        let found = &ours[key];
        // Nine significant digits are printed, so glucose is given to half of 1e-6 mg/dL.
        assert!((found[0] - expected[0]).abs() < 6e-7, "{key}: {} {}", found[0], expected[0]);
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() <= 6e-9 * b.abs().max(1e-6), "{key}: {a} {b}");
        }
    }
}

#[test]
fn simulate_gives_our_own_golden_traces() {
    let golden = workspace().join("fixtures/golden");
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let (patients, meals) = (golden.join("patients.csv"), golden.join("meals.csv"));
    let output = xtask(&[
        "simulate",
        "--patients",
        text(&patients),
        "--meals",
        text(&meals),
        "--days",
        "1",
        "--out",
        text(&out),
        "-q",
    ]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let expected = trace_rows(&golden.join("traces.csv"));
    let found = trace_rows(&out.join("traces.csv"));
    assert_eq!(found.len(), expected.len());
    for (key, expected) in &expected {
        for (a, b) in found[key].iter().zip(expected) {
            // exp() may differ in the last bits between platforms; a day amplifies that little.
            assert!((a - b).abs() <= 1e-9 * b.abs().max(1e-6), "{key}: {a} {b}");
        }
    }
}

#[test]
fn simulate_says_its_minutes_in_few_digits() {
    let golden = workspace().join("fixtures/golden");
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let (patients, meals) = (golden.join("patients.csv"), golden.join("meals.csv"));
    let typed = ["simulate", "--patients", text(&patients), "--meals", text(&meals), "--days", "1"];
    let output = xtask(&[&typed[..], &["--out", text(&out)]].concat());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    let traces = out.join("traces.csv");
    let (steps, minutes) = (column(&traces, "step"), column(&traces, "time_min"));
    assert!(steps.iter().zip(&minutes).all(|(step, minutes)| *minutes == 5.0 * step));
    // Days that are said are days that are written.
    assert!(said.contains(" 1 days in "), "{said}");
    let last = minutes.iter().copied().fold(0.0, f64::max);
    assert!((1435.0..=1440.0).contains(&last), "{last} min");
    let table = fs::read_to_string(&traces).expect("readable");
    for cell in table.lines().skip(1).flat_map(|line| line.split(',').skip(4)) {
        let mantissa = cell.split(['e', 'E']).next().unwrap_or_default();
        let digits = mantissa.trim_start_matches(['-', '0', '.']).replace('.', "");
        assert!(digits.len() <= 10, "{cell}");
    }
}

/// The rows of a `traces.csv`: patient, scenario and step to the numbers behind them.
fn trace_rows(path: &Path) -> std::collections::HashMap<String, Vec<f64>> {
    let table = fs::read_to_string(path).expect("readable");
    let header = table.lines().next().expect("a header");
    // Traces of ours also say the minutes of a step.
    let first = 3 + usize::from(header.split(',').any(|column| column == "time_min"));
    table
        .lines()
        .skip(1)
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let numbers = cells[first..].iter().map(|c| c.parse().expect("a number")).collect();
            (cells[..3].join(","), numbers)
        })
        .collect()
}

/// A column of a CSV file as numbers.
fn column(path: &Path, name: &str) -> Vec<f64> {
    let table = fs::read_to_string(path).expect("readable");
    let mut lines = table.lines();
    let header = lines.next().expect("a header");
    let index = header.split(',').position(|column| column == name).expect("the column");
    lines
        .map(|line| line.split(',').nth(index).expect("a cell").parse().expect("a number"))
        .collect()
}

#[test]
fn published_models_do_not_behave_and_the_command_says_how() {
    let name = "published_models_do_not_behave_and_the_command_says_how";
    let Some(published) = reference_data::find("t1dsim_ai", name) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let run = |arguments: &[&str], out: &str| {
        let out = text(&at(out)).to_owned();
        let all: Vec<&str> = arguments.iter().copied().chain(["--out", &out, "-q"]).collect();
        let output = xtask(&all);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    run(&["import-model", "--from", "t1dsim", text(&published)], "model");
    let model = at("model").join("population.safetensors");
    run(&["trajectories", "--model", text(&model)], "trajectories");
    let read = fs::read(at("trajectories").join("trajectories.json")).expect("written");
    let found: serde_json::Value = serde_json::from_slice(&read).expect("JSON");
    assert_eq!((&found["schema"], &found["passed"]), (&"trajectories/1".into(), &false.into()));
    let findings = found["findings"].as_array().expect("five checks");
    assert_eq!(findings.len(), 5);
    // Without insulin it settles at 68 mg/dL, as others measured.
    let settled = &findings[0]["worst"]["glucose_more_mg_dl"];
    assert!((settled.as_f64().expect("a number") - 68.0).abs() < 0.5, "{settled}");
    // 8 U without food raise glucose.
    assert_eq!((&findings[2]["check"], &findings[2]["passed"]), (&"bolus".into(), &false.into()));
    assert_eq!(findings[2]["worst"]["more"], 8.0);

    let out = at("refused");
    refused(
        &["trajectories", "--model", text(&published.join("LICENSE"))],
        &out,
        &["not a population model"],
    );
}

#[test]
fn tables_are_guessed_and_imported_and_faults_of_a_folder_listed() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let exports = workspace().join("fixtures/downloads");
    let spreadsheet = exports.join("spreadsheet.csv");

    let guess = xtask(&["import", "--from", "table", text(&spreadsheet), "--guess", "-q"]);
    let said = String::from_utf8_lossy(&guess.stdout).into_owned();
    assert_eq!(guess.status.code(), Some(0), "{said}");
    let map =
        "person=Código,time=Fecha y hora,glucose=Glucosa,basal=Basal (U),bolus=Bolo,carbs=Hidratos";
    assert!(said.contains(&format!("--map \"{map}\" --unit glucose=mmol/L")), "{said}");

    let out = at("mine");
    let import = xtask(&[
        "import",
        "--from",
        "table",
        text(&spreadsheet),
        "--map",
        map,
        "--unit",
        "glucose=mmol/L,basal=U/5min",
        "--out",
        text(&out),
    ]);
    let said = String::from_utf8_lossy(&import.stderr).into_owned();
    assert_eq!(import.status.code(), Some(0), "{said}");
    assert!(said.contains("P-02: 2 days, 28.8 + 18.0 U/day, 175 g/day"), "{said}");
    let check = xtask(&["cohort", "check", text(&out)]);
    let said = String::from_utf8_lossy(&check.stderr).into_owned();
    assert_eq!(check.status.code(), Some(0), "{said}");

    let channels = exports.join("channels");
    let toml = channels.join("map.toml");
    let files = ["cgm.csv", "basal.csv", "bolus.csv", "meals.csv"].map(|name| channels.join(name));
    let mut words = vec!["import", "--from", "table", "--map", text(&toml), "--out", text(&out)];
    words.extend(files.iter().map(|file| text(file)));
    let import = xtask(&words);
    let said = String::from_utf8_lossy(&import.stderr).into_owned();
    assert_eq!(import.status.code(), Some(0), "{said}");
    assert!(said.contains("cgm: 2 days, 16.7 + 18.4 U/day"), "{said}");

    let none = at("none");
    refused(&["import", "--from", "table", text(&spreadsheet)], &none, &["--guess proposes a map"]);
    refused(&["import", "--from", "dexcom", text(&spreadsheet)], &none, &["Timestamp", "found"]);
    refused(
        &["import", "--from", "t1dsim", "--utc", text(&spreadsheet)],
        &none,
        &["needs none of"],
    );

    assert_eq!(xtask(&["cohort", "new", text(&at("new"))]).status.code(), Some(0));
    assert_eq!(xtask(&["cohort", "check", text(&at("new"))]).status.code(), Some(0));
    cohort(&at("faulty"), "A,2024-01-01T00:00:00,x,,,,,,\nA,2024-01-01T00:05:00,1,-1,,,,,\n");
    let check = xtask(&["cohort", "check", text(&at("faulty")), "-q"]);
    let said = String::from_utf8_lossy(&check.stderr).into_owned();
    assert_eq!(check.status.code(), Some(1), "{said}");
    assert!(said.contains("records.csv, row 2, column cgm_mg_dl: 'x' is not a number"), "{said}");
    assert!(said.contains("records.csv, row 3, column basal_u_h: -1 is outside"), "{said}");
}
