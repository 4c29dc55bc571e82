//! A delimited text file as a table of text cells that know their line.
//!
//! Every cell is first read as text, so that an error can name its file, line and column. Before
//! the table library sees the bytes, one pass checks that they are UTF-8, that quotes match and
//! that every row has as many fields as the header.

use std::borrow::Cow;
use std::collections::HashSet;
use std::io::{Cursor, Read as _};
use std::path::Path;
use std::sync::Arc;

use polars::prelude::{
    Column, CsvReadOptions, DataType, Field, PlSmallStr, PolarsResult, Schema, SerReader,
    StringChunked,
};

use crate::error::{CohortError, Place, shorten};
use crate::faults::Faults;

/// Most columns: the widest of the known studies has a few hundred.
pub(crate) const MOST_COLUMNS: usize = 4096;
/// Largest file, bytes: 500 people's steps for a year.
const LARGEST_FILE: u64 = 4 << 30;
/// Bytes read at a time.
const PIECE: usize = 1 << 20;
/// Longest row, bytes. The longest of the known studies (a night's sleep stages) has 30 kB.
const LONGEST_ROW: usize = 4 << 20;
/// Longest piece of a column's name in a message, characters.
const SHOWN: usize = 40;

/// A delimited text file split into text cells that know their line.
///
/// Strict: bytes that are not UTF-8, an open quote, a row with another number of fields than the
/// header and a repeated column name are errors that name file and row. Byte-order marks, either
/// line end and blank lines are accepted.
#[derive(Debug)]
pub struct TextTable {
    file: String,
    header: Vec<String>,
    /// The cells without their quotes, a column for each name in the header.
    columns: Vec<StringChunked>,
    /// Line of each row, 1-based.
    lines: Vec<u32>,
}

/// A column of a [`TextTable`].
#[derive(Debug)]
pub struct TextColumn<'a> {
    table: &'a TextTable,
    index: usize,
}

impl TextTable {
    /// Reads the file at `path`; messages call it `name`.
    ///
    /// # Errors
    /// [`CohortError`] with file and row if it cannot be read or is not such a table.
    pub fn read(path: &Path, name: &str, separator: u8) -> Result<Self, CohortError> {
        Self::check(path, name, separator, &mut Faults::strict())
    }

    /// Reads the file and hands rows that cannot be read to `faults`.
    pub(crate) fn check(
        path: &Path,
        name: &str,
        separator: u8,
        faults: &mut Faults,
    ) -> Result<Self, CohortError> {
        Self::of(text(read_text(path, name)?, name)?, name, separator, 1, faults)
    }

    /// The table in a text whose header stands in line `header_line` or below it.
    pub(crate) fn of<'a>(
        text: impl Into<Cow<'a, str>>,
        name: &str,
        separator: u8,
        header_line: usize,
        faults: &mut Faults,
    ) -> Result<Self, CohortError> {
        let text = text.into();
        let rows = scan(&text, name, separator, header_line)?;
        let Some((header_row, rows)) = rows.split_first() else {
            return Err(CohortError::empty(name));
        };
        if header_row.fields > MOST_COLUMNS {
            let what = format!("{} columns, more than {MOST_COLUMNS}", header_row.fields);
            let remedy = "a row is a time and a column a quantity; check the separator and turn it";
            return Err(CohortError::too_large(name, what, remedy));
        }
        let header = fields(header_row.text, separator);
        let mut seen = HashSet::new();
        for column in header.iter().filter(|column| !column.is_empty()) {
            if !seen.insert(column) {
                let column = shorten(column, SHOWN);
                faults.add(CohortError::DuplicateColumn { file: name.into(), column })?;
            }
        }
        let mut body = String::with_capacity(text.len());
        let mut lines = Vec::with_capacity(rows.len());
        for row in rows {
            if row.fields != header.len() {
                faults.add(CohortError::FieldCount {
                    place: Place::row(name, row.line as usize),
                    found: row.fields,
                    expected: header.len(),
                })?;
                continue;
            }
            body.push_str(row.text);
            body.push('\n');
            lines.push(row.line);
        }
        if lines.is_empty() {
            return Err(CohortError::empty(name));
        }
        // Only the copy without header and blank lines is still needed, so a large study whose text
        // is handed over fits into memory once.
        drop(text);
        let columns = columns(body.into_bytes(), header.len(), separator, name)?;
        let height = columns.first().map_or(0, |cells| cells.len());
        if height != lines.len() {
            let reason = format!("{height} rows were read of {}", lines.len());
            return Err(CohortError::table(name, reason));
        }
        Ok(Self { file: name.into(), header, columns, lines })
    }

    /// Number of data rows, at least 1.
    #[must_use]
    pub fn height(&self) -> usize {
        self.lines.len()
    }

    /// The file's name in messages.
    pub(crate) fn file(&self) -> &str {
        &self.file
    }

    /// The column names.
    pub(crate) fn header(&self) -> &[String] {
        &self.header
    }

    /// Index of the column `name` in the header.
    pub(crate) fn index(&self, name: &str) -> Result<usize, CohortError> {
        let index = self.header.iter().position(|column| column == name);
        index.ok_or_else(|| CohortError::missing_column(&self.file, name, &self.header))
    }

    /// The text of row `i` in the column of this index, with surrounding blanks.
    fn whole_cell(&self, i: usize, column: usize) -> &str {
        self.columns[column].get(i).unwrap_or("")
    }

    /// The text of row `i` in the column of this index without surrounding blanks; `None` if that
    /// is empty.
    pub(crate) fn cell(&self, i: usize, column: usize) -> Option<&str> {
        Some(self.whole_cell(i, column).trim()).filter(|text| !text.is_empty())
    }

    /// The place of a cell, for messages.
    pub(crate) fn cell_place(&self, i: usize, column: usize) -> Place {
        Place::cell(&self.file, self.lines[i] as usize, shorten(&self.header[column], SHOWN))
    }

    /// The error that says a cell is not what was expected.
    pub(crate) fn cell_wrong(
        &self,
        i: usize,
        column: usize,
        expected: &'static str,
    ) -> CohortError {
        let text = self.cell(i, column).unwrap_or("");
        CohortError::cell(self.cell_place(i, column), text, expected)
    }

    /// Row `i`, counted from 0 below the header, for messages.
    ///
    /// # Panics
    /// If there is no such row.
    #[must_use]
    pub fn place(&self, i: usize) -> Place {
        Place::row(&self.file, self.lines[i] as usize)
    }

    /// The column `name`, or `None` if there is none.
    pub(crate) fn optional(&self, name: &str) -> Option<TextColumn<'_>> {
        self.column(name).ok()
    }

    /// The column `name`.
    ///
    /// # Errors
    /// If there is none; the error names the columns there are.
    pub fn column(&self, name: &str) -> Result<TextColumn<'_>, CohortError> {
        Ok(self.column_at(self.index(name)?))
    }

    /// The column of this index in the header.
    pub(crate) const fn column_at(&self, index: usize) -> TextColumn<'_> {
        TextColumn { table: self, index }
    }
}

impl TextColumn<'_> {
    /// The text of row `i` without surrounding blanks; `None` if that is empty.
    ///
    /// # Panics
    /// If there is no such row.
    #[must_use]
    pub fn text(&self, i: usize) -> Option<&str> {
        self.table.cell(i, self.index)
    }

    /// The cell of row `i`, for messages.
    ///
    /// # Panics
    /// If there is no such row.
    #[must_use]
    pub fn place(&self, i: usize) -> Place {
        let Self { table, index } = *self;
        Place::cell(&table.file, table.lines[i] as usize, &table.header[index])
    }

    /// The cell of row `i` as a finite number, `None` if it is empty.
    ///
    /// # Errors
    /// [`CohortError::Cell`] for anything else.
    pub fn number(&self, i: usize) -> Result<Option<f64>, CohortError> {
        let Some(text) = self.text(i) else { return Ok(None) };
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            Ok(_) => Err(self.wrong(i, "a finite number; leave the cell empty if it is unknown")),
            Err(_) => Err(self.wrong(i, "a number; write digits with a decimal point")),
        }
    }

    /// The cell of row `i` as a finite number.
    ///
    /// # Errors
    /// [`CohortError::Cell`] for anything else, also if it is empty.
    pub fn required_number(&self, i: usize) -> Result<f64, CohortError> {
        self.number(i)?.ok_or_else(|| self.wrong(i, "a number; the cell is empty"))
    }

    /// The error that says this cell is not what was expected.
    pub(crate) fn wrong(&self, i: usize, expected: &'static str) -> CohortError {
        CohortError::cell(self.place(i), self.table.whole_cell(i, self.index), expected)
    }
}

/// The bytes of a text file. A file or a line that is too long ends the reading before it fills the
/// memory.
pub(crate) fn read_text(path: &Path, name: &str) -> Result<Vec<u8>, CohortError> {
    let failed = CohortError::io(name, "read");
    let mut file = std::fs::File::open(path).map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound => {
            CohortError::missing_file(name, "check the folder and the file's name")
        }
        _ => failed(source),
    })?;
    let metadata = file.metadata().map_err(failed)?;
    if !metadata.is_file() {
        let kind = if metadata.is_dir() { "a folder" } else { "not a file" };
        return Err(CohortError::at(Place::file(name), format!("{kind}; a file is needed")));
    }
    let size = metadata.len();
    if size > LARGEST_FILE {
        let what = format!("{} GiB of text, more than {}", size >> 30, LARGEST_FILE >> 30);
        let remedy = "split it by person, or write Parquet";
        return Err(CohortError::too_large(name, what, remedy));
    }
    let mut bytes: Vec<u8> = Vec::new();
    let (mut line_start, mut line) = (0, 1);
    loop {
        let before = bytes.len();
        let piece = (&mut file).take(PIECE as u64).read_to_end(&mut bytes).map_err(failed)?;
        if piece == 0 {
            return Ok(bytes);
        }
        for (at, _) in bytes[before..].iter().enumerate().filter(|(_, byte)| **byte == b'\n') {
            line_start = before + at + 1;
            line += 1;
        }
        if bytes.len() - line_start > LONGEST_ROW && !bytes[line_start..].contains(&b'\r') {
            let reason = "longer than 4 MiB; line ends are missing or the file is not a table";
            return Err(CohortError::at(Place::row(name, line), reason));
        }
    }
}

/// The bytes as text without a byte-order mark.
fn text(mut bytes: Vec<u8>, name: &str) -> Result<String, CohortError> {
    if bytes.starts_with(b"\xEF\xBB\xBF") {
        bytes.drain(..3);
    }
    let line = |bytes: &[u8], at: usize| 1 + bytes[..at].iter().filter(|b| **b == b'\n').count();
    let wrong = |row, reason: &str| CohortError::at(Place::row(name, row), reason);
    if bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF") {
        return Err(wrong(1, "UTF-16 text; save the file as UTF-8"));
    }
    if let Some(at) = bytes.iter().position(|byte| *byte == 0) {
        return Err(wrong(line(&bytes, at), "a zero byte; the file is not text or is damaged"));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        wrong(line(error.as_bytes(), at), "not UTF-8; save the file as UTF-8")
    })?;
    if text.contains('\r') && !text.contains('\n') {
        return Err(wrong(1, "lines end in carriage returns alone; save with line feeds"));
    }
    Ok(text)
}

/// A row as it is in the text, without its line end.
struct Row<'a> {
    text: &'a str,
    line: u32,
    fields: usize,
}

/// Finds the rows from line `first` on. Blank lines are skipped, but counted as lines.
fn scan<'a>(
    text: &'a str,
    name: &str,
    separator: u8,
    first: usize,
) -> Result<Vec<Row<'a>>, CohortError> {
    let bytes = text.as_bytes();
    let mut rows = Vec::new();
    let mut at: usize = text.split_inclusive('\n').take(first - 1).map(str::len).sum();
    let mut line = u32::try_from(first).unwrap_or(u32::MAX);
    while at < bytes.len() {
        let (start, first_line) = (at, line);
        let wrong = |reason: &str| CohortError::at(Place::row(name, first_line as usize), reason);
        let (mut fields, mut quoted, mut field_start) = (1, false, true);
        while at < bytes.len() {
            let byte = bytes[at];
            if at - start > LONGEST_ROW {
                return Err(wrong("longer than 4 MiB; line ends are missing or a quote is open"));
            }
            if byte == b'\n' {
                line += 1;
                if !quoted {
                    break;
                }
            } else if quoted {
                if byte == b'"' {
                    if bytes.get(at + 1) == Some(&b'"') {
                        at += 1;
                    } else {
                        quoted = false;
                        let next = bytes.get(at + 1).copied();
                        if !matches!(next, None | Some(b'\n' | b'\r')) && next != Some(separator) {
                            return Err(wrong("text after a closing quote"));
                        }
                    }
                }
            } else if byte == b'"' {
                if !field_start {
                    return Err(wrong("a quote inside a field that does not start with one"));
                }
                quoted = true;
            } else if byte == separator {
                fields += 1;
            }
            field_start = byte == separator && !quoted;
            at += 1;
        }
        if quoted {
            return Err(wrong("a quote that is never closed"));
        }
        let text = text[start..at].trim_end_matches('\r');
        if !text.trim().is_empty() {
            rows.push(Row { text, line: first_line, fields });
        }
        at += 1;
    }
    Ok(rows)
}

/// The fields of one row, without their quotes and surrounding blanks.
pub(crate) fn fields(row: &str, separator: u8) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    let mut marks = row.chars().peekable();
    while let Some(mark) = marks.next() {
        let field = fields.last_mut().expect("never empty");
        match mark {
            '"' if quoted && marks.peek() == Some(&'"') => {
                marks.next();
                field.push('"');
            }
            '"' => quoted = !quoted,
            mark if mark == char::from(separator) && !quoted => fields.push(String::new()),
            mark => field.push(mark),
        }
    }
    fields.iter().map(|field| field.trim().to_owned()).collect()
}

/// The cells of the rows in `body`, which have no header, as `width` text columns.
fn columns(
    body: Vec<u8>,
    width: usize,
    separator: u8,
    name: &str,
) -> Result<Vec<StringChunked>, CohortError> {
    let schema: Schema = (0..width)
        .map(|i| Field::new(PlSmallStr::from_string(i.to_string()), DataType::String))
        .collect();
    let mut frame = CsvReadOptions::default()
        .with_rechunk(false)
        .with_has_header(false)
        .with_schema(Some(Arc::new(schema)))
        .with_infer_schema_length(Some(0))
        .map_parse_options(|options| options.with_separator(separator).with_quote_char(Some(b'"')))
        .into_reader_with_file_handle(Cursor::new(body))
        .finish()
        .map_err(|error| CohortError::table(name, error))?;
    // One chunk, so that a cell is found without a search.
    frame.rechunk_mut();
    let texts = frame.columns().iter().map(Column::str).map(|cells| cells.cloned());
    let texts: PolarsResult<Vec<StringChunked>> = texts.collect();
    texts.map_err(|_| CohortError::table(name, "cells are not text"))
}

#[cfg(test)]
mod tests {
    use super::*;

    impl TextTable {
        /// Parses bytes.
        pub(crate) fn parse(
            bytes: Vec<u8>,
            name: &str,
            separator: u8,
        ) -> Result<Self, CohortError> {
            Self::of(text(bytes, name)?, name, separator, 1, &mut Faults::strict())
        }
    }

    fn parse(text: &str) -> Result<TextTable, CohortError> {
        TextTable::parse(text.into(), "t.csv", b',')
    }

    #[test]
    fn marks_line_ends_blank_lines_and_quotes_are_read_and_lines_counted() {
        let table = parse("\u{feff}a,b,\r\n1,\"x\r\n,\"\"y\",\r\n\r\n2,,\n  3 ,z,").expect("good");
        assert_eq!(table.header(), ["a", "b", ""]);
        assert_eq!(table.height(), 3);
        let (a, b) = (table.column("a").expect("a"), table.column("b").expect("b"));
        assert_eq!((a.text(0), b.text(0)), (Some("1"), Some("x\r\n,\"y")));
        assert_eq!((a.number(1).ok(), b.text(1)), (Some(Some(2.0)), None));
        assert_eq!(a.text(2), Some("3"));
        assert_eq!(a.place(2).to_string(), "t.csv, row 6, column a");
    }

    #[test]
    fn what_is_not_a_table_is_said_with_its_line() {
        for (text, says) in [
            ("", "t.csv: no data row"),
            ("\n \n", "t.csv: no data row"),
            ("a,b\n", "t.csv: no data row"),
            ("a,a\n1,2\n", "two columns named 'a'"),
            ("a,b\n1,2\n3\n", "t.csv, row 3: 1 fields where the header has 2"),
            ("a,b\n1,2,3\n", "t.csv, row 2: 3 fields where the header has 2"),
            ("a,b\n1,\"2\n3,4\n", "t.csv, row 2: a quote that is never closed"),
            ("a,b\n1,2\"\n", "t.csv, row 2: a quote inside a field"),
            ("a,b\n1,\"2\"3\n", "t.csv, row 2: text after a closing quote"),
            ("a,b\r1,2\r", "carriage returns alone"),
            ("a,b\n1,\u{0}\n", "t.csv, row 2: a zero byte"),
        ] {
            let message = parse(text).expect_err("refused").to_string();
            assert!(message.contains(says), "{text:?}: {message}");
        }
        let latin =
            TextTable::parse(b"a,b\n1,caf\xE9\n".to_vec(), "t.csv", b',').expect_err("refused");
        assert!(latin.to_string().contains("t.csv, row 2: not UTF-8"), "{latin}");
        let wide = TextTable::parse(b"\xFF\xFEa\0".to_vec(), "t.csv", b',').expect_err("refused");
        assert!(wide.to_string().contains("UTF-16"), "{wide}");
        let long = format!("a,b\n1,{}\n", "x".repeat(LONGEST_ROW));
        let long = parse(&long).expect_err("refused");
        assert!(long.to_string().contains("t.csv, row 2: longer than 4 MiB"), "{long}");
    }

    #[test]
    fn cells_that_are_not_numbers_are_named() {
        let table = parse("a,b\n1,5\n1,=SUM(A1)\n1,NaN\n1,inf\n1,\"1,5\"\n1,\n").expect("good");
        let b = table.column("b").expect("b");
        assert_eq!(b.number(0).ok(), Some(Some(5.0)));
        for (i, says) in [
            (1, "t.csv, row 3, column b: '=SUM(A1)' is not a number"),
            (2, "t.csv, row 4, column b: 'NaN' is not a finite number"),
            (3, "t.csv, row 5, column b: 'inf' is not a finite number"),
            (4, "t.csv, row 6, column b: '1,5' is not a number"),
        ] {
            let message = b.number(i).expect_err("refused").to_string();
            assert!(message.starts_with(says), "{message}");
        }
        assert_eq!(b.number(5).ok(), Some(None));
        let message = b.required_number(5).expect_err("empty").to_string();
        assert!(message.contains("'' is not a number; the cell is empty"), "{message}");
        let missing = table.column("c").expect_err("no such column").to_string();
        assert_eq!(missing, "t.csv: no column 'c'; found a, b");
    }
}
