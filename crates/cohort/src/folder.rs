//! The canonical folder of a cohort: `people.csv` with `records.csv` or `records.parquet`.

use std::path::Path;

use crate::error::CohortError;
use crate::faults::Faults;
use crate::person::Cohort;

mod check;
mod columns;
mod people_table;
mod read_records;
mod record_table;
mod template;
mod write_records;

pub use check::{FolderCheck, check_folder};
pub use template::new_folder;

/// The file of people.
const PEOPLE: &str = "people.csv";
/// The file of records as text.
const RECORDS_CSV: &str = "records.csv";
/// The file of records as Parquet.
const RECORDS_PARQUET: &str = "records.parquet";

/// How `write_folder` stores the records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordsFormat {
    /// `records.csv`: text, every number in the shortest form that reads back exactly.
    Csv,
    /// `records.parquet`: smaller and faster.
    Parquet,
}

impl RecordsFormat {
    const fn file(self) -> &'static str {
        match self {
            Self::Csv => RECORDS_CSV,
            Self::Parquet => RECORDS_PARQUET,
        }
    }
}

/// Reads a cohort folder strictly: any fault is an error that names file, row and column.
///
/// Only `person_id`, `time` and `cgm_mg_dl` must be there; an absent column means "not recorded", an
/// empty `therapy` is `unknown`. Columns beyond the documented ones are ignored, unless their name
/// is close to that of an absent one. Rows absent between a person's first and last row become
/// steps in which nothing is recorded.
///
/// # Errors
/// If a file or column is missing, a row cannot be read, a value is outside the range of its
/// column, rows are repeated, out of order or off the grid, or glucose is in mmol/L.
/// [`check_folder`] lists all of that at once.
pub fn read_folder(folder: &Path) -> Result<Cohort, CohortError> {
    let mut faults = Faults::strict();
    let mut people = people_table::read(folder, &mut faults)?;
    let table = record_table::RecordTable::read(folder, records_format(folder)?, &mut faults)?;
    read_records::fill(&mut people, &table, &mut faults)?;
    Ok(Cohort { people })
}

/// The format of the folder's records.
fn records_format(folder: &Path) -> Result<RecordsFormat, CohortError> {
    match (folder.join(RECORDS_CSV).exists(), folder.join(RECORDS_PARQUET).exists()) {
        (true, true) => {
            let reason = "both records.csv and records.parquet; remove one";
            Err(CohortError::layout(folder.display(), "a cohort folder", reason))
        }
        (true, false) => Ok(RecordsFormat::Csv),
        (false, true) => Ok(RecordsFormat::Parquet),
        (false, false) => {
            let people = folder.join(PEOPLE);
            let remedy = format!("put records.csv or records.parquet beside {}", people.display());
            Err(CohortError::missing_file(RECORDS_CSV, remedy))
        }
    }
}

/// Writes a cohort folder, and creates it if needed. The same cohort gives the same bytes.
///
/// A step in which nothing is recorded gets no row, except the first and last of a person, which
/// keep the grid's ends.
///
/// # Errors
/// If a person has no step, an identifier is invalid or repeated, a value is not finite or outside
/// the range of its column, the folder already holds records in the other format, or a file cannot
/// be written.
pub fn write_folder(
    cohort: &Cohort,
    folder: &Path,
    format: RecordsFormat,
) -> Result<(), CohortError> {
    let other = match format {
        RecordsFormat::Csv => RECORDS_PARQUET,
        RecordsFormat::Parquet => RECORDS_CSV,
    };
    if folder.join(other).exists() {
        let reason = format!("it already holds {other}; remove it or choose another folder");
        let expected = "a folder to write a cohort into";
        return Err(CohortError::layout(folder.display(), expected, reason));
    }
    write_records::check(cohort)?;
    std::fs::create_dir_all(folder)
        .map_err(CohortError::io(&folder.display().to_string(), "written"))?;
    write_records::write(cohort, folder, format)?;
    people_table::write(cohort, folder)
}

/// Writes a file atomically: under a temporary name, which is then renamed.
fn write_whole(
    folder: &Path,
    name: &str,
    write: impl FnOnce(std::fs::File) -> Result<(), CohortError>,
) -> Result<(), CohortError> {
    let failed = CohortError::io(name, "written");
    let partial = folder.join(format!(".{name}.partial"));
    let file = std::fs::File::create(&partial).map_err(failed)?;
    if let Err(error) = write(file) {
        // The write's own error is the one to report, whatever happens to the partial file.
        drop(std::fs::remove_file(&partial));
        return Err(error);
    }
    std::fs::rename(&partial, folder.join(name)).map_err(failed)
}
