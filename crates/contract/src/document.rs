//! A JSON file that is written and read under a schema name.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::ContractError;

/// A JSON file of the workspace.
///
/// The schema name changes when a key is renamed, removed, added or changes its meaning.
pub trait Document: Serialize + DeserializeOwned {
    /// Name of the file in an output folder.
    const FILE: &'static str;
    /// Value of the key `schema`; empty for a file that has no such key.
    const SCHEMA: &'static str;

    /// Checks what types cannot say: that series which belong together have one length.
    ///
    /// # Errors
    /// [`ContractError::UnevenSeries`].
    fn check(&self) -> Result<(), ContractError> {
        Ok(())
    }
}

/// Reads a document. Every key must be known and have the type of its schema.
///
/// # Errors
/// [`ContractError::Schema`] for a file of another schema, [`ContractError::Json`] with line and column for
/// what does not fit, and those of [`Document::check`].
pub fn read<T: Document>(bytes: &[u8]) -> Result<T, ContractError> {
    /// The key that every document has; others are not looked at.
    #[derive(Deserialize)]
    struct Head {
        schema: String,
    }

    // Text that is no JSON, or has no schema, fails below with its place.
    if !T::SCHEMA.is_empty()
        && let Ok(Head { schema }) = serde_json::from_slice(bytes)
        && schema != T::SCHEMA
    {
        return Err(ContractError::Schema { file: T::FILE, found: schema, expected: T::SCHEMA });
    }
    let document: T = serde_json::from_slice(bytes)
        .map_err(|source| ContractError::Json { file: T::FILE, source })?;
    document.check()?;
    Ok(document)
}

/// A kind of document, for what goes through all of them.
#[derive(Debug, Clone, Copy)]
pub struct DocumentKind {
    /// Name of the file in an output folder; several kinds may share it.
    pub file: &'static str,
    pub(crate) same_again: fn(&[u8]) -> Result<bool, ContractError>,
    /// Its schema name, and its JSON Schema.
    #[cfg(test)]
    pub(crate) schema: (&'static str, fn() -> serde_json::Value),
}

impl DocumentKind {
    /// Reads a document and writes it again: whether nothing is lost or changed.
    ///
    /// # Errors
    /// As [`read`].
    pub fn same_again(&self, bytes: &[u8]) -> Result<bool, ContractError> {
        (self.same_again)(bytes)
    }
}

pub(crate) fn same_again<T: Document>(bytes: &[u8]) -> Result<bool, ContractError> {
    let json = |source| ContractError::Json { file: T::FILE, source };
    let document: T = read(bytes)?;
    let again = serde_json::to_value(&document).map_err(json)?;
    let found: serde_json::Value = serde_json::from_slice(bytes).map_err(json)?;
    Ok(again == found)
}

/// Checks that every series has as many values as the one that sets the length.
pub(crate) fn even<'a>(
    file: &'static str,
    (of, expected): (&'static str, usize),
    series: impl IntoIterator<Item = (&'static str, usize)> + 'a,
) -> Result<(), ContractError> {
    match series.into_iter().find(|(_, found)| *found != expected) {
        None => Ok(()),
        Some((series, found)) => {
            Err(ContractError::UnevenSeries { file, series, found, of, expected })
        }
    }
}
