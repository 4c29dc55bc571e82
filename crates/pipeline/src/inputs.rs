//! Small tables that a person hands over, with the place of every fault.

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use cohort::{TextColumn, TextTable};

/// A CSV file with a header, whose cells are required.
#[derive(Debug)]
pub(crate) struct Table(TextTable);

impl Table {
    /// Reads the file.
    ///
    /// # Errors
    /// If it is missing, is not text, has no header, no rows or ragged ones.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        if path.is_dir() {
            bail!("'{}' is a folder; a CSV file is needed", path.display());
        }
        Ok(Self(TextTable::read(path, &path.display().to_string(), b',')?))
    }

    /// Number of rows below the header.
    pub(crate) fn rows(&self) -> usize {
        self.0.height()
    }

    fn column(&self, column: &str) -> Result<TextColumn<'_>> {
        Ok(self.0.column(column)?)
    }

    /// The text of a cell.
    pub(crate) fn text(&self, column: &str, row: usize) -> Result<String> {
        let text = self.column(column)?.text(row).map(str::to_owned);
        text.with_context(|| format!("{}: the cell is empty", self.place(column, row)))
    }

    /// A cell as a finite number.
    pub(crate) fn number(&self, column: &str, row: usize) -> Result<f64> {
        Ok(self.column(column)?.required_number(row)?)
    }

    /// A cell as a whole number that is not negative.
    pub(crate) fn whole(&self, column: &str, row: usize) -> Result<usize> {
        let text = self.text(column, row)?;
        text.parse().with_context(|| {
            format!("{}: '{text}' is not a whole number of 0 or more", self.place(column, row))
        })
    }

    /// Where a cell stands, for a message.
    pub(crate) fn place(&self, column: &str, row: usize) -> String {
        self.column(column)
            .map_or_else(|_| self.0.place(row).to_string(), |column| column.place(row).to_string())
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
        let table = table("a,b\n1,2.5\n-3,x\n").expect("a table");
        for (error, words) in [
            (table.number("b", 1).err(), "row 3, column b: 'x' is not a number"),
            (table.whole("a", 1).err(), "row 3, column a: '-3' is not a whole number"),
            (table.number("c", 0).err(), "no column 'c'; found a, b"),
        ] {
            let message = error.expect("refused").to_string();
            assert!(message.contains(words), "{message}");
        }
    }
}
