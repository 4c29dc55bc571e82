//! Finding a study's files.

use std::path::{Path, PathBuf};

use crate::error::CohortError;

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
        return Err(CohortError::MissingFile {
            file: shown,
            remedy: format!("give a folder or file in the layout of {expected}"),
        });
    }
    if !source.is_dir() {
        return Err(CohortError::WrongLayout {
            file: shown,
            expected,
            reason: "neither a file nor a folder".into(),
        });
    }
    let failed = |error| CohortError::Io {
        file: source.display().to_string(),
        action: "read",
        source: error,
    };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(source).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = name(&path);
        if path.is_file() && wanted(&name) {
            found.push((path, name));
        }
    }
    if found.is_empty() {
        return Err(CohortError::WrongLayout {
            file: shown,
            expected,
            reason: format!("no file named {pattern}"),
        });
    }
    found.sort();
    Ok(found)
}

/// Refuses what is no folder; `with` says what the folder has.
pub(super) fn folder(source: &Path, expected: &'static str, with: &str) -> Result<(), CohortError> {
    let file = source.display().to_string();
    if source.is_dir() {
        Ok(())
    } else if source.exists() {
        let reason = format!("not a folder; give the one that has {with}");
        Err(CohortError::WrongLayout { file, expected, reason })
    } else {
        Err(CohortError::MissingFile { file, remedy: format!("give the folder that has {with}") })
    }
}

/// The last part of a path.
pub(super) fn name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}
