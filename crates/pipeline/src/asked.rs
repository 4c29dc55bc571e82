//! A diagnosis that is asked about one cohort folder and told nothing else.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use contract::Diagnosis;
use contract::blind_check::{Answer, CalibratedPeople};

use crate::children::{self, end, held, running};
use crate::interrupt;
use crate::unseen;

/// Where the diagnosis runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Asked {
    /// In a process of its own.
    AnotherProcess,
    /// In this one: quicker, and for tests of everything else.
    #[cfg(test)]
    ThisProcess,
}

/// The `diagnosis.json` of an answer.
#[derive(Debug, PartialEq)]
pub(crate) struct Written {
    /// Its bytes.
    pub text: Vec<u8>,
    /// How its people were calibrated.
    pub calibrated: CalibratedPeople,
}

/// Longest time of one diagnosis; what takes longer has failed.
const LIMIT: Duration = Duration::from_secs(1800);
/// How often a process is looked after.
const PAUSE: Duration = Duration::from_millis(20);
/// Characters of a failed diagnosis' message that are kept.
const KEPT: usize = 400;

/// Name of the file of the posterior beside the cohort.
const POSTERIOR: &str = "posterior.safetensors";

/// Diagnoses a copy of the cohort in `folder` with the plant `model`, under a random name and without any environment.
/// Nothing that answers has seen the worlds of the hand `unseen`.
///
/// Returns the answer and what was written. A diagnosis that fails is an answer.
///
/// # Errors
/// If the copy cannot be made or a process not be started: that is no fault of the diagnosis.
pub(crate) fn ask(
    folder: &Path,
    model: &str,
    unseen: Option<&str>,
    seed: u64,
    asked: Asked,
) -> Result<(Answer, Option<Written>)> {
    let apart = Scratch::new()?;
    let copy = apart.path().join("cohort");
    copy_files(folder, &copy)?;
    let posterior = unseen::posterior_file(unseen)?;
    fs::write(apart.path().join(POSTERIOR), posterior)
        .context("cannot write in the temporary folder")?;
    let begun = Instant::now();
    let ended = match asked {
        Asked::AnotherProcess => in_another_process(apart.path(), model, seed)?,
        #[cfg(test)]
        Asked::ThisProcess => in_this_process(apart.path(), model, seed),
    };
    let seconds = begun.elapsed().as_secs_f64();
    let text = match ended {
        Ok(()) => fs::read(apart.path().join("answer").join("diagnosis.json"))
            .map_err(|error| format!("no diagnosis.json: {error}")),
        Err(reason) => Err(reason),
    };
    Ok(match text {
        Err(reason) => (Answer::failed(reason, seconds), None),
        Ok(text) => match contract::read::<Diagnosis>(&text) {
            Err(error) => (Answer::failed(error.to_string(), seconds), None),
            Ok(diagnosis) => {
                let calibrated = blind::calibrated_people(&diagnosis.people);
                (blind::answer(diagnosis, seconds), Some(Written { text, calibrated }))
            }
        },
    })
}

/// The arguments after the name of the program, which is the one that runs: the words of its command `diagnose`.
fn arguments(model: &str, seed: u64) -> [String; 13] {
    let seed = seed.to_string();
    [
        "diagnose",
        "--cohort",
        "cohort",
        "--out",
        "answer",
        "--model",
        model,
        "--posterior",
        POSTERIOR,
        "--seed",
        &seed,
        "--threads",
        "1",
    ]
    .map(str::to_owned)
}

/// `Err` holds why there is no answer.
type Ended = Result<(), String>;

fn in_another_process(apart: &Path, model: &str, seed: u64) -> Result<Ended> {
    let program = std::env::current_exe().context("cannot tell which program this is")?;
    let messages = apart.join("messages");
    let errors = File::create(&messages).context("cannot write in the temporary folder")?;
    let mut running = running();
    let child = Command::new(program)
        .args(arguments(model, seed))
        .arg("--quiet")
        .current_dir(apart)
        .env_clear()
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(errors)
        .spawn()
        .context("cannot start the diagnosis")?;
    let child = Arc::new(Mutex::new(child));
    running.push(Arc::clone(&child));
    drop(running);
    let ended = wait(&child);
    children::running().retain(|other| !Arc::ptr_eq(other, &child));
    Ok(match ended? {
        None => Err(format!("killed after {} s", LIMIT.as_secs())),
        Some(status) if status.success() => Ok(()),
        Some(status) => {
            let said = fs::read(&messages).unwrap_or_default();
            let said: String = String::from_utf8_lossy(&said).trim().chars().take(KEPT).collect();
            Err(format!("{status}: {said}"))
        }
    })
}

/// `None` if the process had to be killed.
fn wait(child: &Mutex<Child>) -> Result<Option<ExitStatus>> {
    let begun = Instant::now();
    loop {
        if let Some(status) = held(child).try_wait().context("waiting for the diagnosis")? {
            return Ok(Some(status));
        }
        if begun.elapsed() > LIMIT {
            end(child);
            return Ok(None);
        }
        std::thread::sleep(PAUSE);
    }
}

#[cfg(test)]
fn in_this_process(apart: &Path, model: &str, seed: u64) -> Ended {
    use crate::stages::diagnose;

    let settings = diagnose::Settings {
        cohort: apart.join("cohort"),
        model: model.to_owned(),
        population: None,
        out: apart.join("answer"),
        seed,
        posterior: Some(apart.join(POSTERIOR)),
    };
    diagnose::run(&settings).map_err(|error| format!("{error:#}"))
}

/// A temporary folder under a random name, removed on interruption too.
struct Scratch(Option<tempfile::TempDir>);

impl Scratch {
    fn new() -> Result<Self> {
        let path = |folder: &tempfile::TempDir| folder.path().to_path_buf();
        let folder = interrupt::make_removable(tempfile::tempdir, path)
            .context("cannot make a temporary folder")?;
        Ok(Self(Some(folder)))
    }

    fn path(&self) -> &Path {
        self.0.as_ref().expect("there until it is dropped").path()
    }
}

impl Drop for Scratch {
    /// Gone first, then forgotten: an interruption in between finds nothing left to remove.
    fn drop(&mut self) {
        let path = self.path().to_path_buf();
        drop(self.0.take());
        interrupt::forget(&path);
    }
}

fn copy_files(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir(to).context("cannot make a temporary folder")?;
    let entries = fs::read_dir(from).with_context(|| format!("reading '{}'", from.display()))?;
    for entry in entries {
        let entry = entry.with_context(|| format!("reading '{}'", from.display()))?;
        let name = entry.file_name();
        if !entry.path().is_file() {
            bail!("'{}' is not a file of a cohort", entry.path().display());
        }
        fs::copy(entry.path(), to.join(&name))
            .with_context(|| format!("copying '{}'", name.display()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosed::ODE;
    use contract::blind_check::Verdict;

    #[test]
    fn a_diagnosis_that_fails_is_an_answer() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("people.csv"), "not,a,cohort\n").expect("writable");
        // As another process this is the test program, which knows no diagnosis.
        for asked in [Asked::ThisProcess, Asked::AnotherProcess] {
            let (answer, text) = ask(folder.path(), ODE, None, 1, asked).expect("asked");
            assert_eq!(answer.verdict, Verdict::Failed, "{asked:?}");
            assert!(answer.failure.is_some_and(|reason| !reason.is_empty()), "{asked:?}");
            assert_eq!(text, None);
        }
        let (answer, _) = ask(folder.path(), ODE, None, 1, Asked::ThisProcess).expect("asked");
        let reason = answer.failure.expect("a reason");
        assert!(reason.contains("people.csv"), "{reason}");
    }

    #[test]
    fn what_is_no_cohort_is_not_copied() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("labels")).expect("writable");
        let error =
            ask(folder.path(), ODE, None, 1, Asked::ThisProcess).expect_err("a folder in it");
        assert!(error.to_string().contains("labels"), "{error}");
    }
}
