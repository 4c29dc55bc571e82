//! Finding a study's files.

use std::path::{Path, PathBuf};

use crate::error::CohortError;
use crate::person::is_person_id;

/// What mends a name that is no identifier.
pub(super) const LETTERS: &str = "use letters, digits, '_', '-' and '.'";

/// The files of a source: one file, or the files of a folder whose names satisfy `wanted`, in order
/// of their names. The second part of each is the name for messages.
pub(super) fn files(
    source: &Path,
    expected: &'static str,
    pattern: &str,
    wanted: impl Fn(&str) -> bool,
) -> Result<Vec<(PathBuf, String)>, CohortError> {
    let shown = source.display().to_string();
    if source.is_file() {
        return Ok(vec![(source.to_owned(), name(source))]);
    }
    if !source.exists() {
        let remedy = format!("give a folder or file in the layout of {expected}");
        return Err(CohortError::missing_file(shown, remedy));
    }
    if !source.is_dir() {
        return Err(CohortError::layout(shown, expected, "neither a file nor a folder"));
    }
    let found = named(source, wanted)?;
    if found.is_empty() {
        return Err(CohortError::layout(shown, expected, format!("no file named {pattern}")));
    }
    Ok(found)
}

/// The files of a folder whose names satisfy `wanted`, with their names, in order of these.
pub(super) fn named(
    folder: &Path,
    wanted: impl Fn(&str) -> bool,
) -> Result<Vec<(PathBuf, String)>, CohortError> {
    let all = entries(folder)?.into_iter().map(|path| (path.clone(), name(&path)));
    Ok(all.filter(|(path, name)| path.is_file() && wanted(name)).collect())
}

/// What a folder holds, in order; the system lists files in any.
pub(super) fn entries(folder: &Path) -> Result<Vec<PathBuf>, CohortError> {
    let shown = folder.display().to_string();
    let failed = CohortError::io(&shown, "read");
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        paths.push(entry.map_err(failed)?.path());
    }
    paths.sort();
    Ok(paths)
}

/// Refuses an identifier that files cannot have; `what` becomes it.
pub(super) fn identifier(
    id: &str,
    file: &str,
    expected: &'static str,
    what: &str,
    remedy: &str,
) -> Result<(), CohortError> {
    if is_person_id(id) {
        return Ok(());
    }
    let reason = format!("{what} becomes the person's identifier; {remedy}");
    Err(CohortError::layout(file, expected, reason))
}

/// Refuses what is no folder; `with` says what the folder has.
pub(super) fn folder(source: &Path, expected: &'static str, with: &str) -> Result<(), CohortError> {
    let file = source.display().to_string();
    if source.is_dir() {
        Ok(())
    } else if source.exists() {
        let reason = format!("not a folder; give the one that has {with}");
        Err(CohortError::layout(file, expected, reason))
    } else {
        Err(CohortError::missing_file(file, format!("give the folder that has {with}")))
    }
}

/// The last part of a path.
pub(super) fn name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}
