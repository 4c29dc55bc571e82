//! JSON files that a command wrote, read again.

use std::path::Path;

use anyhow::{Context as _, Result};
use contract::Document;

use crate::models::read_bytes;

/// The document of a folder.
///
/// # Errors
/// With the path, where it cannot be read or is not of its schema.
pub(crate) fn read_document<T: Document>(folder: &Path) -> Result<T> {
    read_document_at(&folder.join(T::FILE))
}

/// The document in a file.
///
/// # Errors
/// As [`read_document`].
pub(crate) fn read_document_at<T: Document>(path: &Path) -> Result<T> {
    contract::read(&read_bytes(path)?).with_context(|| format!("'{}'", path.display()))
}
