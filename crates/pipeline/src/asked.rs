//! A diagnosis that is asked about one cohort folder and told nothing else.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use contract::Diagnosis;
use contract::blind_check::{Answer, CalibratedPeople};

use crate::interrupt::{end, forget, held, make_removable, running};
use crate::unseen::posterior_file;

/// Diagnoses the cohort in a folder with a plant and a seed. The inner error says why there is no answer.
pub(crate) type Diagnose = fn(&Path, &str, u64) -> Result<Result<(), String>>;

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
/// Returns the answer, how its people were calibrated, and the bytes of its `diagnosis.json`. A diagnosis that fails is
/// an answer.
///
/// # Errors
/// If the copy cannot be made or a process not be started: that is no fault of the diagnosis.
pub(crate) fn ask(
    folder: &Path,
    model: &str,
    unseen: Option<&str>,
    seed: u64,
    diagnose: Diagnose,
) -> Result<(Answer, CalibratedPeople, Option<Vec<u8>>)> {
    let scratch = make_removable(tempfile::tempdir, |folder| folder.path().to_path_buf());
    let scratch = Scratch(scratch.context("cannot make a temporary folder")?);
    let apart = scratch.0.path();
    copy_files(folder, &apart.join("cohort"))?;
    fs::write(apart.join(POSTERIOR), posterior_file(unseen)?)
        .context("cannot write in the temporary folder")?;
    let begun = Instant::now();
    let ended = diagnose(apart, model, seed)?;
    let seconds = begun.elapsed().as_secs_f64();
    let read = |()| -> Result<(Diagnosis, Vec<u8>), String> {
        let text = fs::read(apart.join("answer").join("diagnosis.json"))
            .map_err(|error| format!("no diagnosis.json: {error}"))?;
        Ok((contract::read(&text).map_err(|error| error.to_string())?, text))
    };
    Ok(match ended.and_then(read) {
        Err(reason) => (Answer::failed(reason, seconds), CalibratedPeople::default(), None),
        Ok((diagnosis, text)) => {
            let calibrated = blind::calibrated_people(&diagnosis.people);
            (blind::answer(diagnosis, seconds), calibrated, Some(text))
        }
    })
}

/// The command `diagnose` of the program that runs, in a process of its own.
pub(crate) fn in_another_process(
    apart: &Path,
    model: &str,
    seed: u64,
) -> Result<Result<(), String>> {
    let program = std::env::current_exe().context("cannot tell which program this is")?;
    let messages = apart.join("messages");
    let errors = File::create(&messages).context("cannot write in the temporary folder")?;
    let mut others = running();
    let child = Command::new(program)
        .args(["diagnose", "--cohort", "cohort", "--out", "answer", "--model", model])
        .args(["--posterior", POSTERIOR, "--seed", &seed.to_string(), "--threads", "1", "--quiet"])
        .current_dir(apart)
        .env_clear()
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(errors)
        .spawn()
        .context("cannot start the diagnosis")?;
    let child = Arc::new(Mutex::new(child));
    others.push(Arc::clone(&child));
    drop(others);
    let ended = wait(&child);
    running().retain(|other| !Arc::ptr_eq(other, &child));
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

/// The same in this process: quicker, and for tests of everything else.
#[cfg(test)]
pub(crate) fn in_this_process(apart: &Path, model: &str, seed: u64) -> Result<Result<(), String>> {
    use crate::stages::diagnose;

    let settings = diagnose::Settings {
        cohort: apart.join("cohort"),
        model: model.to_owned(),
        population: None,
        out: apart.join("answer"),
        seed,
        posterior: Some(apart.join(POSTERIOR)),
    };
    Ok(diagnose::run(&settings).map_err(|error| format!("{error:#}")))
}

/// A temporary folder under a random name, removed on interruption too.
struct Scratch(tempfile::TempDir);

impl Drop for Scratch {
    /// Gone first, then forgotten: an interruption in between finds nothing left to remove.
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(self.0.path());
        forget(self.0.path());
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
        let places: [(&str, Diagnose); 2] =
            [("this process", in_this_process), ("another", in_another_process)];
        for (place, diagnose) in places {
            let (answer, _, text) = ask(folder.path(), ODE, None, 1, diagnose).expect("asked");
            assert_eq!(answer.verdict, Verdict::Failed, "{place}");
            assert!(answer.failure.is_some_and(|reason| !reason.is_empty()), "{place}");
            assert_eq!(text, None, "{place}");
        }
        let (answer, ..) = ask(folder.path(), ODE, None, 1, in_this_process).expect("asked");
        let reason = answer.failure.expect("a reason");
        assert!(reason.contains("people.csv"), "{reason}");
    }

    #[test]
    fn what_is_no_cohort_is_not_copied() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("labels")).expect("writable");
        let error = ask(folder.path(), ODE, None, 1, in_this_process).expect_err("a folder in it");
        assert!(error.to_string().contains("labels"), "{error}");
    }
}
