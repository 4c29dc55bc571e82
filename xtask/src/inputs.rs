//! Small tables that a person hands over, read with the place of every fault.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, bail};
use polars::prelude::{CsvParseOptions, CsvReadOptions, DataFrame, SerReader as _};

/// A CSV file with a header, its cells kept as text until they are asked for.
#[derive(Debug)]
pub(crate) struct Table {
    path: PathBuf,
    frame: DataFrame,
}

impl Table {
    /// Reads the file.
    ///
    /// # Errors
    /// If it is missing, is not text, has no header or ragged rows.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        if !path.is_file() {
            bail!("there is no file '{}'", path.display());
        }
        let frame = CsvReadOptions::default()
            .with_infer_schema_length(Some(0))
            .with_parse_options(CsvParseOptions::default().with_truncate_ragged_lines(false))
            .try_into_reader_with_file_path(Some(path.to_path_buf()))
            .and_then(|reader| reader.finish())
            .with_context(|| format!("'{}' is not a CSV table with a header", path.display()))?;
        if frame.height() == 0 {
            bail!("'{}' has a header but no rows", path.display());
        }
        Ok(Self { path: path.to_path_buf(), frame })
    }

    /// Number of rows below the header.
    pub(crate) fn rows(&self) -> usize {
        self.frame.height()
    }

    /// The text of a cell; empty if nothing stands there.
    pub(crate) fn text(&self, column: &str, row: usize) -> Result<&str> {
        let series = self.frame.column(column).map_err(|_| {
            let present: Vec<&str> =
                self.frame.get_column_names().iter().map(|name| name.as_str()).collect();
            anyhow!(
                "'{}' has no column '{column}'; it has {}",
                self.path.display(),
                present.join(", ")
            )
        })?;
        let texts = series
            .str()
            .with_context(|| format!("column '{column}' of '{}'", self.path.display()))?;
        Ok(texts.get(row).unwrap_or("").trim())
    }

    /// A cell as a finite number.
    pub(crate) fn number(&self, column: &str, row: usize) -> Result<f64> {
        let text = self.text(column, row)?;
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => bail!("{}: '{text}' is not a number", self.place(column, row)),
        }
    }

    /// A cell as a whole number that is not negative.
    pub(crate) fn whole(&self, column: &str, row: usize) -> Result<usize> {
        let text = self.text(column, row)?;
        text.parse().map_err(|_| {
            anyhow!("{}: '{text}' is not a whole number of 0 or more", self.place(column, row))
        })
    }

    /// Where a cell stands, for a message: the header is row 1.
    pub(crate) fn place(&self, column: &str, row: usize) -> String {
        format!("'{}', row {}, column '{column}'", self.path.display(), row + 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<Table> {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("t.csv");
        std::fs::write(&path, text).expect("writable");
        Table::read(&path)
    }

    #[test]
    fn cells_are_found_by_name_and_row() {
        let table = table("a,b\n1,2.5\n3,x\n").expect("a table");
        assert_eq!(table.rows(), 2);
        assert_eq!(table.number("b", 0).expect("a number"), 2.5);
        assert_eq!(table.whole("a", 1).expect("whole"), 3);
    }

    #[test]
    fn faults_name_their_place() {
        let table = table("a,b\n1,2.5\n3,x\n").expect("a table");
        let error = table.number("b", 1).expect_err("text").to_string();
        assert!(error.contains("row 3, column 'b': 'x' is not a number"), "{error}");
        let error = table.number("c", 0).expect_err("missing").to_string();
        assert!(error.contains("no column 'c'; it has a, b"), "{error}");
    }

    #[test]
    fn an_empty_table_is_refused() {
        assert!(table("a,b\n").is_err());
        assert!(table("").is_err());
    }
}
