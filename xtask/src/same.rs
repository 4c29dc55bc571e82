//! `same`: whether two output folders hold the same results, for a change that must not change any.
//!
//! Every file has to be in both with the same bytes. Of JSON files these values may differ: times, the name of the
//! schema, and in manifests the command line, paths and hashes, which follow from the former. Reports and tables for
//! people (`.html`, `.txt`) repeat times and are left out: what they say lies in the JSON files.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use clap::Args;
use serde_json::Value;

/// Compare two output folders: the results of a change that must change none.
#[derive(Debug, Args)]
pub(crate) struct SameArgs {
    /// Output folder of the program before the change.
    before: PathBuf,
    /// Output folder of the program after it.
    after: PathBuf,
}

/// Keys whose values may differ.
const FREE: [&str; 2] = ["seconds", "schema"];
/// The same in manifests.
const FREE_IN_MANIFESTS: [&str; 3] = ["command", "path", "sha256"];
/// Differences that are named; the others are counted.
const NAMED: usize = 20;

/// Runs the command.
pub(crate) fn run(args: &SameArgs) -> Result<()> {
    let (before, after) = (files(&args.before)?, files(&args.after)?);
    ensure!(!before.is_empty(), "'{}' holds no file", args.before.display());
    let mut wrong: Vec<String> = before
        .symmetric_difference(&after)
        .map(|name| format!("{}: in one of the two alone", name.display()))
        .collect();
    for name in before.intersection(&after) {
        wrong.extend(differences(&args.before, &args.after, name)?);
    }
    let more = wrong.len().saturating_sub(NAMED);
    wrong.truncate(NAMED);
    ensure!(wrong.is_empty(), "not the same:\n  {}\n  and {more} more", wrong.join("\n  "));
    cli::note(format!("same: {} files", before.len()));
    Ok(())
}

/// Files for people.
const REPEATED: [&str; 2] = ["html", "txt"];

/// Paths of all files within a folder, those for people aside.
fn files(root: &Path) -> Result<BTreeSet<PathBuf>> {
    let mut found = BTreeSet::new();
    let mut open = vec![root.to_path_buf()];
    while let Some(folder) = open.pop() {
        let entries = fs::read_dir(&folder)
            .with_context(|| format!("cannot read the folder '{}'", folder.display()))?;
        for entry in entries {
            let path = entry?.path();
            if path.is_dir() {
                open.push(path);
            } else if !path.extension().is_some_and(|e| REPEATED.iter().any(|known| e == *known)) {
                found.insert(path.strip_prefix(root)?.to_path_buf());
            }
        }
    }
    Ok(found)
}

/// In what one file differs.
fn differences(before: &Path, after: &Path, name: &Path) -> Result<Vec<String>> {
    let read = |root: &Path| {
        let path = root.join(name);
        fs::read(&path).with_context(|| format!("cannot read '{}'", path.display()))
    };
    let (one, other) = (read(before)?, read(after)?);
    if one == other {
        return Ok(Vec::new());
    }
    let place = name.display().to_string();
    if name.extension().is_none_or(|extension| extension != "json") {
        return Ok(vec![format!("{place}: other bytes")]);
    }
    let mut free: Vec<&str> = FREE.to_vec();
    if name.file_name().is_some_and(|file| file == "manifest.json") {
        free.extend(FREE_IN_MANIFESTS);
    }
    let parsed = |bytes: &[u8]| serde_json::from_slice::<Value>(bytes).context(place.clone());
    let mut wrong = Vec::new();
    compare(&parsed(&one)?, &parsed(&other)?, &free, &place, &mut wrong);
    Ok(wrong)
}

fn compare(one: &Value, other: &Value, free: &[&str], place: &str, wrong: &mut Vec<String>) {
    match (one, other) {
        (Value::Object(one), Value::Object(other)) => {
            let keys: BTreeSet<&String> = one.keys().chain(other.keys()).collect();
            for key in keys.into_iter().filter(|key| !free.contains(&key.as_str())) {
                let place = format!("{place}: {key}");
                match (one.get(key), other.get(key)) {
                    (Some(one), Some(other)) => compare(one, other, free, &place, wrong),
                    _ => wrong.push(format!("{place}: in one of the two alone")),
                }
            }
        }
        (Value::Array(one), Value::Array(other)) if one.len() == other.len() => {
            for (index, (one, other)) in one.iter().zip(other).enumerate() {
                compare(one, other, free, &format!("{place}[{index}]"), wrong);
            }
        }
        _ if one == other => {}
        _ => wrong.push(format!("{place}: {one} and {other}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_schema_names_may_differ_and_nothing_else() {
        let compared = |one: &str, other: &str, free: &[&str]| {
            let read = |text: &str| serde_json::from_str::<Value>(text).expect("JSON");
            let mut wrong = Vec::new();
            compare(&read(one), &read(other), free, "f", &mut wrong);
            wrong
        };
        let one = r#"{"schema": "a/1", "rows": [{"seconds": 1.0, "m": 2.0}]}"#;
        let other = r#"{"schema": "a/2", "rows": [{"seconds": 3.0, "m": 2.0}]}"#;
        assert!(compared(one, other, &FREE).is_empty());
        let changed = other.replace("2.0", "2.5");
        assert_eq!(compared(one, &changed, &FREE), ["f: rows[0]: m: 2.0 and 2.5"]);
        let longer = r#"{"rows": [1, 2]}"#;
        assert_eq!(compared(r#"{"rows": [1]}"#, longer, &FREE).len(), 1);
        assert_eq!(compared(r"{}", longer, &FREE), ["f: rows: in one of the two alone"]);
        assert_eq!(compared(r#"{"path": "a"}"#, r#"{"path": "b"}"#, &FREE).len(), 1);
        let manifest = [FREE.as_slice(), &FREE_IN_MANIFESTS].concat();
        assert!(compared(r#"{"path": "a"}"#, r#"{"path": "b"}"#, &manifest).is_empty());
    }

    #[test]
    fn folders_have_to_hold_the_same_files() {
        let root = std::env::temp_dir().join(format!("same-{}", std::process::id()));
        let write = |name: &str, text: &str| {
            let path = root.join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
            fs::write(path, text).expect("writable");
        };
        write("a/x.json", r#"{"seconds": 1}"#);
        write("b/x.json", r#"{"seconds": 2}"#);
        write("a/report.html", "one");
        write("a/1/t.csv", "1\n");
        write("b/1/t.csv", "1\n");
        let asked =
            |after: &str| run(&SameArgs { before: root.join("a"), after: root.join(after) });
        asked("b").expect("the same");
        write("b/1/t.csv", "2\n");
        let error = asked("b").expect_err("another row").to_string();
        assert!(error.contains("t.csv: other bytes"), "{error}");
        write("b/more.csv", "");
        assert!(asked("b").expect_err("a file more").to_string().contains("more.csv"));
        fs::remove_dir_all(&root).expect("removable");
    }
}
