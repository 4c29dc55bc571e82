//! `report`: one HTML file from whatever an output folder holds.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use report::{Inputs, Part, render};

use crate::files::entries;
use crate::manifest::REPORT;
use crate::next_step::wrote;
use crate::output::write_whole;
use crate::{Manifest, note};

/// What several stages of one run write; of all but manifests the report shows the last.
const OF_MANY_STAGES: [Part; 2] = [Part::Manifest, Part::DataInUse];

/// Settings of `report`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// An output folder of any command.
    pub folder: PathBuf,
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let folder = &args.folder;
    if !folder.is_dir() {
        bail!("there is no folder '{}'", folder.display());
    }
    let inputs = gather(folder)?;
    let html = render(&inputs).context("rendering the report")?;
    let path = folder.join(REPORT);
    write_whole(&path, html.as_bytes())?;
    note(format!("report: {}", path.display()));
    wrote("report", folder, None);
    Ok(())
}

/// Writes the report of a folder that is being built, with the manifest it will get.
pub(crate) fn write_into(folder: &Path, manifest: &Manifest) -> Result<()> {
    let mut inputs = gather_parts(folder)?;
    let text = serde_json::to_vec(manifest)?;
    inputs.read(Part::Manifest, text.as_slice())?;
    let html = render(&inputs).context("rendering the report")?;
    let path = folder.join(REPORT);
    fs::write(&path, html).with_context(|| format!("cannot write '{}'", path.display()))
}

/// Everything a report shows that `folder` and its stage folders hold.
///
/// # Errors
/// If there is nothing, or a file does not hold what its name says.
pub(crate) fn gather(folder: &Path) -> Result<Inputs> {
    let inputs = gather_parts(folder)?;
    if inputs.is_empty() {
        let shown = |part: &Part| !matches!(part, Part::Manifest | Part::Seal | Part::Truth);
        let parts = Part::ALL.into_iter().filter(shown);
        let names: Vec<&str> = parts.map(Part::file_name).collect();
        let what = Manifest::read(folder)
            .map_or_else(String::new, |manifest| format!("the output of {}, ", manifest.stage));
        bail!(
            "'{}', {what}holds nothing that a report shows: none of {}",
            folder.display(),
            names.join(", ")
        );
    }
    Ok(inputs)
}

fn gather_parts(folder: &Path) -> Result<Inputs> {
    let mut folders = entries(folder)?;
    // Hidden folders are unfinished outputs.
    folders.retain(|path| {
        path.is_dir()
            && path.file_name().is_some_and(|name| !name.to_string_lossy().starts_with('.'))
    });
    folders.insert(0, folder.to_path_buf());
    let mut inputs = Inputs::default();
    for (part, path) in places(&folders)? {
        let file =
            File::open(&path).with_context(|| format!("cannot open '{}'", path.display()))?;
        inputs.read(part, BufReader::new(file)).with_context(|| format!("'{}'", path.display()))?;
    }
    Ok(inputs)
}

/// The parts that folders hold. What one stage alone writes and is there twice belongs to two runs.
fn places(folders: &[PathBuf]) -> Result<Vec<(Part, PathBuf)>> {
    let mut places: Vec<(Part, PathBuf)> = Vec::new();
    for folder in folders {
        for part in Part::ALL {
            let path = folder.join(part.file_name());
            if !path.is_file() {
                continue;
            }
            let before = places.iter().find(|(before, _)| *before == part);
            if let Some((_, before)) = before.filter(|_| !OF_MANY_STAGES.contains(&part)) {
                bail!(
                    "'{}' and '{}' are of two runs; give the folder of one of them",
                    before.display(),
                    path.display()
                );
            }
            places.push((part, path));
        }
    }
    Ok(places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_runs_under_one_folder_are_not_mixed() {
        let parent = tempfile::tempdir().expect("a folder");
        let of = |run: &str, part: Part| {
            fs::create_dir_all(parent.path().join(run)).expect("a folder");
            fs::write(parent.path().join(run).join(part.file_name()), "{}").expect("written");
        };
        let found = || places(&[parent.path().join("a"), parent.path().join("b")]);
        for part in OF_MANY_STAGES {
            of("a", part);
            of("b", part);
        }
        of("a", Part::Diagnosis);
        of("b", Part::Training);
        assert_eq!(found().expect("parts of one run").len(), 6);
        of("b", Part::Diagnosis);
        let error = gather(parent.path()).expect_err("two runs").to_string();
        assert!(error.contains("diagnosis.json' are of two runs"), "{error}");
    }
}
