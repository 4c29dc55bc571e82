//! What the table library reads of a Parquet file that may be damaged.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};

use polars::prelude::{DataFrame, ParquetReader, PolarsError, SerReader as _};

use crate::error::CohortError;

/// What `read` returns of `file`. The library panics on some damaged files, which becomes an error
/// here; its own message still goes to the panic hook.
pub(crate) fn guarded<T>(
    file: &str,
    read: impl FnOnce() -> Result<T, CohortError>,
) -> Result<T, CohortError> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| Err(damaged(file)))
}

/// A file whose damage has no better name.
pub(crate) fn damaged(file: &str) -> CohortError {
    CohortError::table(file, "damaged, or of a kind that cannot be read")
}

/// The columns of `file`, with as many rows each. The library makes sure of that in builds with
/// debug assertions alone.
pub(crate) fn frame(file: &str, reader: ParquetReader<File>) -> Result<DataFrame, CohortError> {
    let frame = reader.finish().map_err(fault(file))?;
    let rows = frame.height();
    match frame.columns().iter().find(|column| column.len() != rows) {
        None => Ok(frame),
        Some(column) => {
            let (name, found) = (column.name(), column.len());
            let reason = format!("column {name} has {found} rows, others {rows}; {REMEDY}");
            Err(CohortError::table(file, reason))
        }
    }
}

const REMEDY: &str = "it is damaged or cut off; write it again from its source";

/// Gives the error of `file` for the library's, without the words of the library's types.
pub(crate) fn fault(file: &str) -> impl Fn(PolarsError) -> CohortError + '_ {
    move |error| {
        let text = error.to_string();
        let reason = match text.rsplit_once("specification: ") {
            Some((_, reason)) => format!("{reason}; {REMEDY}"),
            None if text.contains(['{', '[']) => REMEDY.to_owned(),
            None => format!("{text}; {REMEDY}"),
        };
        CohortError::table(file, reason)
    }
}
