//! Runs that are killed at any moment: the next run ends with the bytes of a run that nobody disturbed. A few kills of each
//! command always run; a hundred in all where `T1D_SLOW` is set.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

const SWITCH: &str = "T1D_SLOW";
/// Keys of what the clock said.
const CLOCK: [&str; 1] = ["seconds"];
/// Kills of one command.
const FEW: u32 = 3;
const MANY: u32 = 25;

fn kills() -> u32 {
    if std::env::var_os(SWITCH).is_some() { MANY } else { FEW }
}

fn start(arguments: &[&str], out: &Path) -> Child {
    Command::new(env!("CARGO_BIN_EXE_t1d-twins"))
        .args(arguments)
        .args(["-q", "--out"])
        .arg(out)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

/// Runs to the end; the message of a run that fails.
fn ended(child: Child) -> Result<(), String> {
    let output = child.wait_with_output().expect("a child");
    if output.status.success() {
        return Ok(());
    }
    Err(format!("{}: {}", output.status, String::from_utf8_lossy(&output.stderr)))
}

/// The files below a folder with their bytes. Of a manifest the command line is left out, of reports and tables of verdicts
/// all, of what else the clock said its seconds: they are not part of the work.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    collect(folder, folder, &mut found);
    found
}

fn collect(root: &Path, folder: &Path, found: &mut BTreeMap<PathBuf, Vec<u8>>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(root, &path, found);
            continue;
        }
        let name = path.strip_prefix(root).expect("below it").to_path_buf();
        let bytes = fs::read(&path).expect("readable");
        let bytes = match path.file_name().and_then(|name| name.to_str()) {
            Some("report.html") => Vec::new(),
            Some("manifest.json") => without(&bytes, &["command", "inputs", "outputs"]),
            // What the clock said is no result.
            Some("training.json" | "conformance.json") => without(&bytes, &CLOCK),
            // The table of verdicts has a column of seconds, and stands among the tables of a pipeline.
            Some("conformance.txt" | "tables.txt") => Vec::new(),
            _ => bytes,
        };
        found.insert(name, bytes);
    }
}

/// JSON without these keys, at any depth.
fn without(json: &[u8], keys: &[&str]) -> Vec<u8> {
    fn remove(value: &mut serde_json::Value, keys: &[&str]) {
        match value {
            serde_json::Value::Object(object) => {
                object.retain(|key, _| !keys.contains(&key.as_str()));
                object.values_mut().for_each(|value| remove(value, keys));
            }
            serde_json::Value::Array(values) => {
                values.iter_mut().for_each(|value| remove(value, keys));
            }
            _ => {}
        }
    }
    let mut value: serde_json::Value = serde_json::from_slice(json).expect("JSON, and whole");
    remove(&mut value, keys);
    value.to_string().into_bytes()
}

/// Kills a run at moments spread over its length, lets the next one end, and compares.
fn survives(arguments: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    let undisturbed = folder.path().join("undisturbed");
    let begun = Instant::now();
    ended(start(arguments, &undisturbed)).expect("an undisturbed run");
    let length = begun.elapsed();
    let expected = files(&undisturbed);
    let apart = folder.path().join("apart");
    let out = apart.join("out");
    for kill in 0..kills() {
        // Multiples of the golden section fall evenly and never on the same moment.
        let moment = length.mul_f64((f64::from(kill + 1) * 0.618_034).fract());
        let mut child = start(arguments, &out);
        std::thread::sleep(moment);
        let _ = child.kill();
        child.wait().expect("a child");
        if out.exists() && arguments[0] != "pipeline" {
            assert_eq!(differing(&files(&out), &expected), "", "{arguments:?}: half a folder");
        }
        ended(start(arguments, &out)).expect("the next run");
        assert_eq!(differing(&files(&out), &expected), "", "{arguments:?}, killed at {moment:?}");
        let beside = fs::read_dir(&apart).expect("a folder").count();
        assert_eq!(beside, 1, "{arguments:?}, killed at {moment:?}: something is left beside");
        if kill % 2 == 0 {
            // Every other kill meets the folder of an earlier run, which is replaced.
            fs::remove_dir_all(&out).expect("ours");
        }
    }
}

/// The first difference of two folders in words; empty where there is none.
fn differing(found: &BTreeMap<PathBuf, Vec<u8>>, expected: &BTreeMap<PathBuf, Vec<u8>>) -> String {
    let names = |files: &BTreeMap<PathBuf, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    if names(found) != names(expected) {
        return format!("files {:?} in place of {:?}", names(found), names(expected));
    }
    let differing = found.iter().find(|(name, bytes)| expected[*name] != **bytes);
    differing.map_or_else(String::new, |(name, _)| format!("{} has other bytes", name.display()))
}

/// Kills a run again and again before it ends, lets the last one end, and compares: what was finished is kept.
fn goes_on(arguments: &[&str]) {
    /// Pieces into which the length of a run is cut.
    const PIECES: f64 = 8.0;
    let folder = tempfile::tempdir().expect("a folder");
    let undisturbed = folder.path().join("undisturbed");
    let begun = Instant::now();
    ended(start(arguments, &undisturbed)).expect("an undisturbed run");
    let longest = begun.elapsed().div_f64(PIECES);
    let apart = folder.path().join("apart");
    let out = apart.join("out");
    for kill in 0..kills() {
        let mut child = start(arguments, &out);
        std::thread::sleep(longest.mul_f64((f64::from(kill + 1) * 0.618_034).fract()));
        let _ = child.kill();
        child.wait().expect("a child");
    }
    ended(start(arguments, &out)).expect("the last run");
    assert_eq!(differing(&files(&out), &files(&undisturbed)), "", "{arguments:?}");
    assert_eq!(fs::read_dir(&apart).expect("a folder").count(), 1, "something is left beside");
}

/// The embedded cohort and the model that ships with the program.
fn inputs() -> (String, String) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = |path: &str| root.join(path).to_str().expect("UTF-8").to_owned();
    (text("fixtures/embedded/cohort"), text("crates/nn-statespace/model/population.safetensors"))
}

#[test]
fn a_killed_diagnosis_leaves_nothing_that_the_next_run_minds() {
    let (cohort, _) = inputs();
    survives(&["diagnose", "--cohort", &cohort]);
}

#[test]
fn a_killed_training_ends_with_the_same_weights() {
    survives(&["train"]);
}

#[test]
fn killed_twins_are_trained_again_to_the_same_bytes() {
    let (cohort, model) = inputs();
    survives(&["twin", "--cohort", &cohort, "--model", &model, "--epochs", "2"]);
}

#[test]
fn a_pipeline_that_is_killed_ends_with_the_same_bytes() {
    if std::env::var_os(SWITCH).is_none() {
        #[expect(clippy::print_stderr, reason = "a skipped test must say that it was skipped")]
        {
            eprintln!("skipped: a killed pipeline takes minutes; set {SWITCH}=1 to run it");
        }
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let world = folder.path().join("world");
    let drawn = ["worlds", "--people", "1", "--days", "20"];
    ended(start(&drawn, &world)).expect("a world of one person");
    let cohort = world.join("001/cohort");
    let (_, model) = inputs();
    goes_on(&["pipeline", "--cohort", cohort.to_str().expect("UTF-8"), "--model", &model]);
}

#[test]
fn two_runs_on_one_folder_never_mix() {
    let (cohort, _) = inputs();
    let arguments = ["reconcile", "--cohort", &cohort];
    let folder = tempfile::tempdir().expect("a folder");
    let alone = folder.path().join("alone");
    ended(start(&arguments, &alone)).expect("an undisturbed run");
    let apart = folder.path().join("apart");
    let out = apart.join("out");
    let both = [start(&arguments, &out), start(&arguments, &out)].map(ended);
    let refused: Vec<&String> = both.iter().filter_map(|end| end.as_ref().err()).collect();
    assert!(refused.len() <= 1, "{refused:?}");
    for message in refused {
        assert!(message.contains("another run is writing"), "{message}");
    }
    assert_eq!(differing(&files(&out), &files(&alone)), "");
    assert_eq!(fs::read_dir(&apart).expect("a folder").count(), 1, "something is left beside");
}
