//! What can be wrong with a cohort or with a foreign file, and where.

use std::borrow::Borrow;
use std::fmt::Display;

use chrono::NaiveDateTime;

/// Longest piece of a cell in a message, characters.
const SHOWN: usize = 40;

/// Where in a table something was found.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The file, relative to the folder that was read.
    pub file: String,
    /// Line in a text file (1-based, the header is line 1), or data row in a Parquet file
    /// (1-based).
    pub row: Option<usize>,
    /// The column's name.
    pub column: Option<String>,
}

impl Place {
    /// A whole file.
    #[must_use]
    pub fn file(file: impl Into<String>) -> Self {
        Self { file: file.into(), row: None, column: None }
    }

    /// A row of a file.
    #[must_use]
    pub fn row(file: impl Into<String>, row: usize) -> Self {
        Self { file: file.into(), row: Some(row), column: None }
    }

    /// A cell of a file.
    #[must_use]
    pub fn cell(file: impl Into<String>, row: usize, column: impl Into<String>) -> Self {
        Self { file: file.into(), row: Some(row), column: Some(column.into()) }
    }

    /// A column of a file.
    #[must_use]
    pub fn column(file: impl Into<String>, column: impl Into<String>) -> Self {
        Self { file: file.into(), row: None, column: Some(column.into()) }
    }
}

impl Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.file)?;
        if let Some(row) = self.row {
            write!(f, ", row {row}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ", column {column}")?;
        }
        Ok(())
    }
}

/// Every way in which reading, writing or using a cohort fails.
#[derive(Debug, thiserror::Error)]
pub enum CohortError {
    /// The operating system refused.
    #[error("{file}: cannot be {action}: {source}")]
    Io {
        /// The file at fault.
        file: String,
        /// `read` or `written`.
        action: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file that cannot be read or written as what it should be: missing, empty, too large, in
    /// another layout, no table, or not text.
    #[error("{place}: {reason}")]
    Unreadable {
        /// The file, and the row if there is one.
        place: Place,
        /// What is wrong with it, and what mends it.
        reason: String,
    },
    /// What the caller says cannot be: an option, or units that make glucose nobody has.
    #[error("{0}")]
    Refused(String),
    /// A required column is missing.
    #[error("{file}: no column '{column}'; found {found}")]
    MissingColumn {
        /// The file at fault.
        file: String,
        /// The missing column.
        column: String,
        /// The columns of the file.
        found: String,
    },
    /// An unknown column whose name is close to that of an absent one.
    #[error("{file}: unknown column '{found}': did you mean '{known}'? rename it, or remove it")]
    NearColumn {
        /// The file at fault.
        file: String,
        /// The column of the file.
        found: String,
        /// The column it probably is.
        known: &'static str,
    },
    /// A foreign table can be read in two ways.
    #[error("{place}: {reason}; {remedy}")]
    Undecided {
        /// Where it shows.
        place: Place,
        /// What is open.
        reason: String,
        /// How to decide it.
        remedy: &'static str,
    },
    /// A column name occurs twice.
    #[error("{file}: two columns named '{column}'; rename or remove one")]
    DuplicateColumn {
        /// The file at fault.
        file: String,
        /// The repeated name.
        column: String,
    },
    /// A row has more or fewer fields than the header.
    #[error(
        "{place}: {found} fields where the header has {expected}; the row is cut off or has a stray separator"
    )]
    FieldCount {
        /// The row.
        place: Place,
        /// Fields found.
        found: usize,
        /// Fields of the header.
        expected: usize,
    },
    /// A cell is not what its column requires.
    #[error("{place}: '{value}' is not {expected}")]
    Cell {
        /// The cell.
        place: Place,
        /// Its text, shortened.
        value: String,
        /// What the column requires.
        expected: &'static str,
    },
    /// A number is outside the range of its column.
    #[error("{place}: {} is outside {low} to {high}{}; {remedy}", short(*value), spaced(unit))]
    OutOfRange {
        /// The cell.
        place: Place,
        /// The number.
        value: f64,
        /// Smallest allowed value.
        low: f64,
        /// Largest allowed value.
        high: f64,
        /// Unit of the column.
        unit: &'static str,
        /// How to fix it.
        remedy: &'static str,
    },
    /// A person is listed twice.
    #[error("{place}: person '{person}' is listed twice; keep one row per person")]
    DuplicatePerson {
        /// The second row.
        place: Place,
        /// The person's identifier.
        person: String,
    },
    /// A row names a person who is not in the list of people.
    #[error("{place}: person '{person}' is not in people.csv; add a row there")]
    UnknownPerson {
        /// The row.
        place: Place,
        /// The person's identifier.
        person: String,
    },
    /// A person has no record at all.
    #[error("{file}: no row for person '{person}'; remove the person from people.csv or add rows")]
    NoRecord {
        /// The file of records.
        file: String,
        /// The person's identifier.
        person: String,
    },
    /// Two rows of a person have the same time.
    #[error("{place}: person '{person}' has two rows at {time}; keep one row per step")]
    DuplicateStep {
        /// The second row.
        place: Place,
        /// The person's identifier.
        person: String,
        /// The repeated time.
        time: NaiveDateTime,
    },
    /// A row lies before the row above it.
    #[error("{place}: person '{person}' at {time} comes after {previous}; sort the rows by time")]
    OutOfOrder {
        /// The row.
        place: Place,
        /// The person's identifier.
        person: String,
        /// Time of the row.
        time: NaiveDateTime,
        /// Time of the person's row above.
        previous: NaiveDateTime,
    },
    /// A time is not a multiple of five minutes.
    #[error("{place}: {time} is off the 5-minute grid; steps start at minute 0, 5, 10, ...")]
    OffGrid {
        /// The row.
        place: Place,
        /// The time.
        time: NaiveDateTime,
    },
    /// A record would be longer than any study, or than what it holds can fill.
    #[error(
        "{place}: person '{person}' spans {days} days, more than {limit}; a time is probably wrong"
    )]
    TooLong {
        /// The row that extends the record.
        place: Place,
        /// The person's identifier.
        person: String,
        /// The span it would have.
        days: i64,
        /// The longest allowed span.
        limit: i64,
    },
    /// Glucose that can only be mmol/L.
    #[error(
        "{place}: person '{person}' has a median of {median}: looks like mmol/L; multiply by 18 or import"
    )]
    LooksLikeMmol {
        /// The column.
        place: Place,
        /// The person's identifier.
        person: String,
        /// Median of the column.
        median: f64,
    },
    /// A record's grid cannot be built.
    #[error("record of {steps} steps from {start}: {reason}")]
    Grid {
        /// First step.
        start: NaiveDateTime,
        /// Number of steps.
        steps: usize,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A step beyond the end of a record was requested.
    #[error("person '{person}': steps {start}..{end} were asked for, the record has {len}")]
    Range {
        /// The person's identifier.
        person: String,
        /// First step requested.
        start: usize,
        /// One past the last step requested.
        end: usize,
        /// Steps in the record.
        len: usize,
    },
    /// A dose is missing and the caller refuses to guess.
    #[error(
        "person '{person}', step {step}, column {column}: not recorded; choose steps with recorded doses or say that missing doses are zero"
    )]
    MissingDose {
        /// The person's identifier.
        person: String,
        /// The step.
        step: usize,
        /// The channel's column name.
        column: &'static str,
    },
    /// A value that must be a finite number is not.
    #[error("person '{person}', step {step}, column {column}: {value} is not a finite number")]
    NonFinite {
        /// The person's identifier.
        person: String,
        /// The step.
        step: usize,
        /// The channel's column name.
        column: &'static str,
        /// The value.
        value: f64,
    },
    /// A window rule cannot be applied.
    #[error("{rule} of {value}: {remedy}")]
    Rule {
        /// The rule's field.
        rule: &'static str,
        /// Its value.
        value: f64,
        /// How to fix it.
        remedy: &'static str,
    },
}

/// A number; a very large one with its exponent.
fn short(value: f64) -> String {
    if value.abs() < 1e15 { value.to_string() } else { format!("{value:e}") }
}

/// A unit after its number, if there is one.
fn spaced(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}

/// A text of at most `limit` characters, with control characters escaped.
pub(crate) fn shorten(text: &str, limit: usize) -> String {
    let mut shown: String = text.chars().take(limit).flat_map(char::escape_debug).collect();
    if text.chars().nth(limit).is_some() {
        shown.push_str("...");
    }
    shown
}

impl CohortError {
    /// The error of a file or of a row, with what is wrong there.
    pub(crate) fn at(place: Place, reason: impl Into<String>) -> Self {
        Self::Unreadable { place, reason: reason.into() }
    }

    /// The error of a whole file.
    fn of_file(file: impl Display, reason: impl Into<String>) -> Self {
        Self::at(Place::file(file.to_string()), reason)
    }

    /// The error of a required file that is missing.
    pub(crate) fn missing_file(file: impl Display, remedy: impl Display) -> Self {
        Self::of_file(file, format!("no such file; {remedy}"))
    }

    /// The error of a file without a data row.
    pub(crate) fn empty(file: impl Display) -> Self {
        Self::of_file(file, "no data row; a header and at least one row are needed")
    }

    /// The error of a file that is too large to be what it should be; found before it is read.
    pub(crate) fn too_large(file: impl Display, what: impl Display, remedy: &str) -> Self {
        Self::of_file(file, format!("{what}; {remedy}"))
    }

    /// The error of a file whose `header` lacks a required column.
    pub(crate) fn missing_column(
        file: impl Display,
        column: &str,
        header: &[impl Borrow<str>],
    ) -> Self {
        Self::MissingColumn {
            file: file.to_string(),
            column: column.to_owned(),
            found: shorten(&header.join(", "), 4 * SHOWN),
        }
    }

    /// The error of a cell whose text is not what its column requires.
    pub(crate) fn cell(place: Place, text: &str, expected: &'static str) -> Self {
        Self::Cell { place, value: shorten(text, SHOWN), expected }
    }

    /// The error of a file or folder that is not in the layout of `expected`.
    pub(crate) fn layout(file: impl Display, expected: &str, reason: impl Display) -> Self {
        Self::of_file(file, format!("not in the layout of {expected}: {reason}"))
    }

    /// The error of a file that is no readable table.
    pub(crate) fn table(file: impl Display, reason: impl Display) -> Self {
        Self::of_file(file, format!("not a readable table: {reason}"))
    }

    /// The error of what the user says in `option`.
    pub(crate) fn option(option: impl Display, reason: impl Display) -> Self {
        Self::Refused(format!("{option}: {reason}"))
    }

    /// Gives the error of a file that cannot be `action` for the system's reason.
    pub(crate) fn io(file: &str, action: &'static str) -> impl Fn(std::io::Error) -> Self + Copy {
        move |source| Self::Io { file: file.into(), action, source }
    }

    /// The error of a table that could not be written. The table library wraps the system's reason in words
    /// about what it reads.
    pub(crate) fn not_written(file: &str, error: &impl Display) -> Self {
        let text = error.to_string();
        let reason = text.rsplit("IO error: ").next().unwrap_or_default().to_owned();
        Self::io(file, "written")(std::io::Error::other(reason))
    }

    /// File, row and column, as far as the error has them.
    #[must_use]
    pub fn place(&self) -> Option<Place> {
        match self {
            Self::Io { file, .. } | Self::NoRecord { file, .. } => Some(Place::file(file)),
            Self::DuplicateColumn { file, column: name }
            | Self::MissingColumn { file, column: name, .. }
            | Self::NearColumn { file, found: name, .. } => Some(Place::column(file, name)),
            Self::Unreadable { place, .. }
            | Self::FieldCount { place, .. }
            | Self::Cell { place, .. }
            | Self::OutOfRange { place, .. }
            | Self::DuplicatePerson { place, .. }
            | Self::UnknownPerson { place, .. }
            | Self::DuplicateStep { place, .. }
            | Self::OutOfOrder { place, .. }
            | Self::OffGrid { place, .. }
            | Self::TooLong { place, .. }
            | Self::LooksLikeMmol { place, .. }
            | Self::Undecided { place, .. } => Some(place.clone()),
            Self::Grid { .. }
            | Self::Range { .. }
            | Self::MissingDose { .. }
            | Self::NonFinite { .. }
            | Self::Rule { .. }
            | Self::Refused(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_cheap_to_hand_on() {
        // Every `Result` of the crate carries this many bytes.
        assert!(size_of::<CohortError>() < 128, "{}", size_of::<CohortError>());
    }

    #[test]
    fn a_place_names_what_is_known() {
        assert_eq!(Place::file("a.csv").to_string(), "a.csv");
        assert_eq!(Place::row("a.csv", 3).to_string(), "a.csv, row 3");
        assert_eq!(Place::column("a.csv", "b").to_string(), "a.csv, column b");
        assert_eq!(Place::cell("a.csv", 3, "b").to_string(), "a.csv, row 3, column b");
    }
}
