//! Malformed inputs of every command: each is refused in words, in bounded time and memory, and leaves nothing behind.
//!
//! The table of cases and messages lies in `malformed.tsv` in the tests' folder of the build after
//! `cargo test -p cli --test it malformed`.

mod case;
mod cohorts;
mod documents;
mod folders;
mod imports;
mod options;
mod run;
mod weights;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use case::{Case, Cases};
use run::{Ended, run};

/// Cases side by side.
const AT_ONCE: usize = 2;
/// Fewest cases.
const FEWEST: usize = 200;

#[test]
fn every_malformed_input_is_refused_in_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut cases = Cases::new(folder.path());
    cohorts::add(&mut cases);
    weights::add(&mut cases);
    documents::add(&mut cases);
    imports::add(&mut cases);
    options::add(&mut cases);
    folders::add(&mut cases);
    let ground = cases;
    let cases = &ground.all;
    assert!(cases.len() >= FEWEST, "{} cases", cases.len());

    let ended = run_all(cases, folder.path());
    let mut table = String::from("case\tcommand\tseconds\tMiB\tmessage\n");
    let mut faults = String::new();
    for (case, ended) in cases.iter().zip(&ended) {
        let here = |text: &str| text.replace(&*folder.path().to_string_lossy(), "");
        let message = here(&ended.message).replace(['\n', '\t'], " ");
        writeln!(
            table,
            "{}\t{}\t{:.2}\t{}\t{message}",
            case.name, case.arguments[0], ended.seconds, ended.peak_mib
        )
        .expect("writing to a String cannot fail");
        if !ended.faults.is_empty() {
            let (arguments, all) = (here(&case.arguments.join(" ")), ended.faults.join("; "));
            writeln!(faults, "{} [{arguments}]: {all}\n    {message}", case.name)
                .expect("writing to a String cannot fail");
        }
    }
    let written = Path::new(env!("CARGO_TARGET_TMPDIR")).join("malformed.tsv");
    std::fs::write(&written, table).expect("writable");
    let left = unfinished(folder.path());
    assert!(left.is_empty(), "left behind: {left:?}");
    assert!(faults.is_empty(), "of {} cases these end badly:\n{faults}", cases.len());
}

/// Hidden folders and files of the program anywhere below a folder.
fn unfinished(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let name = name.to_string_lossy().into_owned();
        if name.starts_with(".building") || name.ends_with(".lock") || name.ends_with(".partial") {
            found.push(path);
        } else if path.is_dir() && !path.is_symlink() {
            found.extend(unfinished(&path));
        }
    }
    found
}

/// How each case ended, in their order.
fn run_all(cases: &[Case], folder: &Path) -> Vec<Ended> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, Ended)>> = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for worker in 0..AT_ONCE {
            let (next, done) = (&next, &done);
            scope.spawn(move || {
                let scratch = folder.join(format!("scratch{worker}"));
                std::fs::create_dir_all(&scratch).expect("a folder");
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = cases.get(index) else { return };
                    let ended = run(case, &scratch);
                    done.lock().expect("no worker panics").push((index, ended));
                }
            });
        }
    });
    let mut done = done.into_inner().expect("no worker panics");
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, ended)| ended).collect()
}
