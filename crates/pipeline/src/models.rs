//! Model files on disk.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use nn_statespace::PopulationModel;
use twins::Twin;

/// A file's bytes.
///
/// # Errors
/// With the path, also where it names a folder.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    if path.is_dir() {
        bail!("'{}' is a folder; a file is needed", path.display());
    }
    fs::read(path).with_context(|| format!("cannot read '{}'", path.display()))
}

/// The population model in a `.safetensors` file.
pub(crate) fn read_population(path: &Path) -> Result<PopulationModel> {
    PopulationModel::from_safetensors(&read_bytes(path)?)
        .with_context(|| format!("'{}' is not a population model", path.display()))
}

/// The twin in a `.safetensors` file, on the population model it was trained on.
pub(crate) fn read_twin(path: &Path, population: Arc<PopulationModel>) -> Result<Twin> {
    Twin::from_bytes(&read_bytes(path)?, population)
        .with_context(|| format!("'{}' is not a twin of this population model", path.display()))
}

/// The files in `folder` whose names begin and end so, in order.
pub(crate) fn find(folder: &Path, begins: &str, ends: &str) -> Result<Vec<PathBuf>> {
    let mut found = fs::read_dir(folder)
        .and_then(|entries| entries.map(|e| e.map(|e| e.path())).collect::<Result<Vec<_>, _>>())
        .with_context(|| format!("cannot read the folder '{}'", folder.display()))?;
    found.retain(|path| {
        path.file_name()
            .and_then(|name| name.to_str())
            .is_some_and(|name| name.starts_with(begins) && name.ends_with(ends))
    });
    found.sort();
    Ok(found)
}
