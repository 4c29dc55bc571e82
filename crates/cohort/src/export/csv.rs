//! Rows of a CSV file.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use crate::error::CohortError;

/// A CSV file that is being written.
pub struct Csv {
    file: String,
    writer: BufWriter<File>,
}

/// A cell of a CSV file.
pub enum Cell<'a> {
    /// Words; what a spreadsheet would take for a formula gets an apostrophe.
    Text(&'a str),
    /// Digits that read back as the same number; nothing if it is missing.
    Number(Option<f64>),
}

impl Csv {
    /// Begins a file with a header.
    ///
    /// # Errors
    /// [`CohortError::Io`] if it cannot be written.
    pub fn new(folder: &Path, name: &str, header: &[&str]) -> Result<Self, CohortError> {
        let file = File::create(folder.join(name)).map_err(CohortError::io(name, "written"))?;
        let mut csv = Self { file: name.into(), writer: BufWriter::new(file) };
        csv.row(header.iter().map(|name| Cell::Text(name)))?;
        Ok(csv)
    }

    /// Writes a row.
    ///
    /// # Errors
    /// [`CohortError::Io`] if it cannot be written.
    pub fn row<'a>(
        &mut self,
        cells: impl IntoIterator<Item = Cell<'a>>,
    ) -> Result<(), CohortError> {
        let cells = cells.into_iter().map(|cell| match cell {
            Cell::Text(text) => guarded(text),
            Cell::Number(Some(value)) => Cow::Owned(value.to_string()),
            Cell::Number(None) => Cow::Borrowed(""),
        });
        let line = cells.collect::<Vec<_>>().join(",") + "\n";
        self.writer.write_all(line.as_bytes()).map_err(CohortError::io(&self.file, "written"))
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// [`CohortError::Io`] if it cannot be written.
    pub fn finish(mut self) -> Result<(), CohortError> {
        self.writer.flush().map_err(CohortError::io(&self.file, "written"))
    }
}

/// A text as a cell that no spreadsheet computes, quoted where it must be.
fn guarded(text: &str) -> Cow<'_, str> {
    let formula = text.starts_with(['=', '+', '-', '@', '\t', '\r']);
    let text = if formula { Cow::Owned(format!("'{text}")) } else { Cow::Borrowed(text) };
    if text.contains(['"', ',', '\n', '\r']) {
        return Cow::Owned(format!("\"{}\"", text.replace('"', "\"\"")));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::guarded;

    #[test]
    fn formulas_and_separators_are_guarded() {
        for (text, cell) in [
            ("p1", "p1"),
            ("2024-03-01 08:00:00", "2024-03-01 08:00:00"),
            ("=HYPERLINK(\"x\")", "\"'=HYPERLINK(\"\"x\"\")\""),
            ("+1", "'+1"),
            ("-2", "'-2"),
            ("@SUM(A1)", "'@SUM(A1)"),
            ("\t=1", "'\t=1"),
            ("a,b", "\"a,b\""),
        ] {
            assert_eq!(guarded(text), cell);
        }
    }
}
