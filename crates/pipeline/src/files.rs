//! Files and folders that are read: models, documents that a command wrote.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use contract::Document;
use nn_statespace::PopulationModel;
use twins::Twin;

/// Largest file that is read as a whole, bytes; a model has some hundred kB.
const LARGEST: u64 = 1 << 28;

/// A file's bytes.
///
/// # Errors
/// With the path, also where it names no file, or one that is larger than any model or table of ours.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    check_size(path)?;
    fs::read(path).with_context(|| format!("cannot read '{}'", path.display()))
}

/// Refuses what is no file, or one larger than is read as a whole.
pub(crate) fn check_size(path: &Path) -> Result<()> {
    if path.is_dir() {
        bail!("'{}' is a folder; a file is needed", path.display());
    }
    if !path.exists() {
        bail!("there is no file '{}'", path.display());
    }
    if !path.is_file() {
        bail!("'{}' is not a file; a file is needed", path.display());
    }
    let metadata = fs::metadata(path);
    let size = metadata.with_context(|| format!("cannot read '{}'", path.display()))?.len();
    if size > LARGEST {
        bail!(
            "'{}' has {:.1} GiB, more than any model or table that is read here; give another file",
            path.display(),
            size as f64 / f64::from(1 << 30)
        );
    }
    Ok(())
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

/// The document of a folder.
///
/// # Errors
/// With the path, where it cannot be read or is not of its schema.
pub(crate) fn read_document<T: Document>(folder: &Path) -> Result<T> {
    let path = folder.join(T::FILE);
    contract::read(&read_bytes(&path)?).with_context(|| format!("'{}'", path.display()))
}

/// Everything in `folder`, in order.
pub(crate) fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = fs::read_dir(folder)
        .and_then(|entries| entries.map(|e| e.map(|e| e.path())).collect::<Result<Vec<_>, _>>())
        .with_context(|| format!("cannot read the folder '{}'", folder.display()))?;
    found.sort();
    Ok(found)
}

/// The files in `folder` whose names begin and end so, in order.
pub(crate) fn find(folder: &Path, begins: &str, ends: &str) -> Result<Vec<PathBuf>> {
    let mut found = entries(folder)?;
    found.retain(|path| {
        path.file_name()
            .and_then(|name| name.to_str())
            .is_some_and(|name| name.starts_with(begins) && name.ends_with(ends))
    });
    Ok(found)
}
