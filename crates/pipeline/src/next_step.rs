//! What to look at after a command: one line, for every command that writes something.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use contract::blind_check::PlantedCheck;
use contract::{Document as _, TwinsTable};

use crate::interrupt::held;
use crate::manifest::{program, shown};
use crate::progress::note;
use crate::result_file::result_file;

/// Where the command `twin` puts the files of people.
const TWINS: &str = "twins";

/// What was written last.
#[derive(Debug, Clone)]
struct Written {
    command: String,
    folder: PathBuf,
    cohort: Option<PathBuf>,
}

static LAST: Mutex<Option<Written>> = Mutex::new(None);

/// Remembers what a command wrote; `cohort` is the folder that it read, if it read one.
pub(crate) fn wrote(command: &str, folder: &Path, cohort: Option<&Path>) {
    *held(&LAST) = Some(Written {
        command: command.to_owned(),
        folder: folder.to_path_buf(),
        cohort: cohort.map(Path::to_path_buf),
    });
}

/// Says what to look at next; nothing where nothing was written since the last time.
pub fn say_next() {
    let last = held(&LAST).take();
    if let Some(Written { command, folder, cohort }) = last {
        note(format!("next: {}", next(program(), &command, &folder, cohort.as_deref())));
    }
}

/// What to do with the output of a command.
fn next(program: &str, command: &str, folder: &Path, cohort: Option<&Path>) -> String {
    let out = shown(folder);
    let file = |name: &str| shown(&folder.join(name));
    let cohort = cohort.map_or_else(|| "COHORT".to_owned(), shown);
    match command {
        "blind-check" if folder.join(PlantedCheck::FILE).is_file() => {
            format!("look at {}", file("planted.md"))
        }
        "blind-check" | "diagnose" | "pipeline" | "report" => {
            format!("open {} in a browser", file("report.html"))
        }
        "import" | "reconcile" | "cohort check" => {
            format!("{program} diagnose --cohort {out}")
        }
        "cohort new" => {
            let filled = format!("fill in {} and {}", file("people.csv"), file("records.csv"));
            format!(
                "{filled}, then {program} cohort check {out}; docs/cohort.md describes the columns"
            )
        }
        "train" => format!("{program} verify --model {}", file("population.safetensors")),
        // A network that was trained elsewhere has no region of its own.
        "import-model" => {
            let model = file("population.safetensors");
            format!("{program} verify --model {model} --region REGION.json")
        }
        "twin" if !holds_files(&folder.join(TWINS)) => {
            format!("read why nobody has a twin in {}", file(TwinsTable::FILE))
        }
        "twin" => format!("{program} evaluate --cohort {cohort} --twins {out}"),
        "baselines" => format!(
            "{program} evaluate --cohort {cohort} --twins TWINS --baselines {out}, with TWINS that \
             '{program} twin' wrote"
        ),
        "verify" | "evaluate" => format!("{program} report {out} draws it as a page"),
        "evidence" => format!("{program} train-posterior --table {out}"),
        "train-posterior" => {
            format!(
                "the six files of {out} take the place of those in crates/gap/posterior and crates/pipeline/posterior"
            )
        }
        "worlds" => format!("{program} diagnose --cohort {}", shown(&first_cohort(folder))),
        "simulate" | "replay" => format!("plot the columns of {}", file("traces.csv")),
        "development-set" => format!("look at {}, or {program} train", file("weeks.csv")),
        "export" => format!("read the files in {out}; docs/foreign-formats.md says with what"),
        _ => match result_file(command).filter(|name| folder.join(name).is_file()) {
            Some(name) => format!("look at {}; docs/outputs.md lists its keys", file(name)),
            None => format!("look at the files in {out}; docs/outputs.md lists their keys"),
        },
    }
}

/// Whether a folder is there and holds something.
fn holds_files(folder: &Path) -> bool {
    std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some())
}

/// The cohort of the first of several worlds.
fn first_cohort(folder: &Path) -> PathBuf {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let cohorts = entries.map(|entry| entry.path().join("cohort")).filter(|path| path.is_dir());
    cohorts.min().unwrap_or_else(|| folder.to_path_buf())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_follows_names_folders_that_can_be_pasted() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir_all(folder.path().join("b/cohort")).expect("writable");
        std::fs::create_dir_all(folder.path().join("a/cohort")).expect("writable");
        let worlds = next("p", "worlds", folder.path(), None);
        assert!(worlds.ends_with("a/cohort"), "{worlds}");
        let cohort = Path::new("my cohort");
        std::fs::create_dir(folder.path().join(TWINS)).expect("writable");
        let twin = || next("p", "twin", folder.path(), Some(cohort));
        assert!(twin().starts_with("read why nobody has a twin in "), "{}", twin());
        std::fs::write(folder.path().join(TWINS).join("a.safetensors"), "").expect("writable");
        assert!(twin().starts_with("p evaluate --cohort 'my cohort' --twins "), "{}", twin());
        assert_eq!(
            next("p", "diagnose", Path::new("out"), Some(cohort)),
            "open out/report.html in a browser"
        );
    }
}
