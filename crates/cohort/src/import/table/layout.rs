//! Encoding, separator and header of a text file or workbook that anybody may have made.

use std::collections::BTreeSet;
use std::path::Path;

use crate::error::{CohortError, Place, shorten};
use crate::faults::Faults;
use crate::import::workbook::{self, Workbook};
use crate::near_name::plain;
use crate::text_table::{TextTable, fields, read_text};

/// Lines at the top among which the header is looked for.
const TOP: usize = 60;
/// Bytes of a line at the top that are looked at.
const LOOKED_AT: usize = 1 << 18;
/// Most cells of a sheet, and most bytes of their text.
const MOST_CELLS: usize = 1 << 25;
const LARGEST_SHEET: usize = 1 << 29;
const SEPARATORS: [u8; 4] = [b',', b';', b'\t', b'|'];

/// A file as a table, and how it was written.
#[derive(Debug)]
pub(super) struct Opened {
    pub(super) table: TextTable,
    /// The file's name without its ending.
    pub(super) stem: String,
    /// What was found out, in words: encoding and separator, or the sheet, and the line of the
    /// header.
    pub(super) form: String,
}

impl Opened {
    /// Reads a file; `wanted` are the columns by which the header is known, if any are. `sheet` is
    /// that of a workbook; without it the first that is seen.
    pub(super) fn read(
        path: &Path,
        name: &str,
        wanted: &[&str],
        sheet: Option<&str>,
    ) -> Result<Self, CohortError> {
        if workbook::is_archive(path) {
            return Self::of_workbook(Workbook::open(path, name)?, name, wanted, sheet);
        }
        if sheet.is_some() {
            let reason = format!("{name} is no Excel workbook; leave the option out");
            return Err(CohortError::option("--sheet", reason));
        }
        Self::of(read_text(path, name)?, name, wanted)
    }

    /// The same of the bytes of a text.
    pub(super) fn of(bytes: Vec<u8>, name: &str, wanted: &[&str]) -> Result<Self, CohortError> {
        let (text, encoding) = decode(bytes, name)?;
        let (separator, above) = header(&text, &SEPARATORS, wanted);
        let between = match separator {
            b',' => "commas",
            b';' => "semicolons",
            b'\t' => "tabs",
            _ => "vertical bars",
        };
        let form = format!("{encoding}, columns between {between}");
        Self::with(&text, name, separator, above, form)
    }

    fn of_workbook(
        mut book: Workbook,
        name: &str,
        wanted: &[&str],
        sheet: Option<&str>,
    ) -> Result<Self, CohortError> {
        let sheets = book.sheets();
        let of = match sheets.len() {
            1 => String::new(),
            several => format!(", of {several} sheets"),
        };
        let chosen = match sheet {
            Some(wanted) => sheets.iter().find(|sheet| sheet.name.trim() == wanted.trim()),
            None => sheets.iter().find(|sheet| workbook::is_visible(sheet)),
        };
        let Some(chosen) = chosen else {
            let names: Vec<&str> = sheets.iter().map(|sheet| sheet.name.as_str()).collect();
            let reason = format!("{name} has the sheets {}", shorten(&names.join(", "), 160));
            return Err(CohortError::option("--sheet", reason));
        };
        let text = sheet_text(&mut book, &chosen.name, name)?;
        let (separator, above) = header(&text, b",", wanted);
        let form = format!("Excel workbook, sheet '{}'{of}", shorten(&chosen.name, 40));
        Self::with(&text, name, separator, above, form)
    }

    fn with(
        text: &str,
        name: &str,
        separator: u8,
        above: usize,
        mut form: String,
    ) -> Result<Self, CohortError> {
        let table = TextTable::of(text, name, separator, above + 1, &mut Faults::strict())?;
        let stem = Path::new(name).file_stem();
        let stem = stem.map_or(name.into(), |stem| stem.to_string_lossy()).into_owned();
        if above > 0 {
            form += &format!(", header in line {}", above + 1);
        }
        Ok(Self { table, stem, form })
    }
}

/// A sheet as text between commas, each row in the line of its number.
fn sheet_text(book: &mut Workbook, sheet: &str, name: &str) -> Result<String, CohortError> {
    let (mut rows, mut width, mut size) = (Vec::new(), 0, 0);
    // Columns of times: whether one of them is not midnight.
    let mut timed: Vec<Option<bool>> = Vec::new();
    book.rows(sheet, |number, cells| {
        let mut row = Vec::with_capacity(cells.len());
        for (column, cell) in cells {
            if let workbook::Cell::Time(time) = cell {
                timed.resize(timed.len().max(column + 1), None);
                let midnight = time.time() == chrono::NaiveTime::MIN;
                timed[*column] = Some(timed[*column].unwrap_or(false) || !midnight);
            }
            let text = cell.text().into_owned();
            size += text.len() + size_of::<(usize, String)>();
            width = width.max(column + 1);
            row.push((*column, text));
        }
        rows.push((number, row));
        if size > LARGEST_SHEET || rows.len().saturating_mul(width) > MOST_CELLS {
            let what = format!("sheet '{}' is too large", shorten(sheet, 40));
            let remedy = "save the rows and columns that are needed as CSV";
            return Err(CohortError::too_large(name, what, remedy));
        }
        Ok(())
    })?;
    let mut text = String::with_capacity(size + rows.len() * width);
    let mut line = 1;
    for (number, mut row) in rows {
        text.extend(std::iter::repeat_n('\n', number.saturating_sub(line)));
        line = number;
        row.sort_by_key(|(column, _)| *column);
        let mut at = 0;
        for (column, cell) in row {
            text.extend(std::iter::repeat_n(',', column - at));
            at = column;
            // A column of dates alone has no time of day.
            let dates = timed.get(column) == Some(&Some(false));
            let cell = if dates { cell.trim_end_matches(" 00:00:00") } else { cell.as_str() };
            text.push('"');
            text.extend(cell.chars().map(|c| if matches!(c, '\n' | '\r' | '"') { ' ' } else { c }));
            text.push('"');
        }
        text.extend(std::iter::repeat_n(',', width - 1 - at));
    }
    Ok(text)
}

/// The bytes as text, and the name of their encoding.
fn decode(bytes: Vec<u8>, name: &str) -> Result<(String, &'static str), CohortError> {
    let wrong = |reason: &str| CohortError::at(Place::row(name, 1), reason);
    for (mark, reason) in [
        (
            &b"\xD0\xCF\x11\xE0"[..],
            "an old Excel workbook, or one with a password; save the sheet as .xlsx or CSV",
        ),
        (b"\x1F\x8B", "compressed, not text; unpack it first"),
        (b"PAR1", "a Parquet file, not text; write it as CSV"),
        (b"%PDF", "a PDF, not a table; export the data as CSV"),
        (b"<", "a web page or XML, not a table; export the data as CSV"),
    ] {
        if bytes.starts_with(mark) {
            return Err(wrong(reason));
        }
    }
    let (text, encoding) = if let Some(rest) = bytes.strip_prefix(b"\xEF\xBB\xBF") {
        let text = std::str::from_utf8(rest).map_err(|_| wrong("damaged UTF-8; save it again"))?;
        (text.to_owned(), "UTF-8 with a byte-order mark")
    } else if let Some(rest) = bytes.strip_prefix(b"\xFF\xFE") {
        (wide(rest, u16::from_le_bytes).ok_or_else(|| wrong("damaged UTF-16"))?, "UTF-16")
    } else if let Some(rest) = bytes.strip_prefix(b"\xFE\xFF") {
        (wide(rest, u16::from_be_bytes).ok_or_else(|| wrong("damaged UTF-16"))?, "UTF-16")
    } else {
        match String::from_utf8(bytes) {
            Ok(text) => (text, "UTF-8"),
            Err(error) => (windows_1252(error.as_bytes(), name)?, "Windows-1252 (not UTF-8)"),
        }
    };
    if let Some(at) = text.find('\0') {
        let row = 1 + text[..at].matches('\n').count();
        let reason = "a zero byte; the file is not text or is damaged";
        return Err(CohortError::at(Place::row(name, row), reason));
    }
    if text.contains('\r') && !text.contains('\n') {
        return Ok((text.replace('\r', "\n"), encoding));
    }
    Ok((text, encoding))
}

fn wide(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Option<String> {
    if !bytes.len().is_multiple_of(2) {
        return None;
    }
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    char::decode_utf16(units).collect::<Result<String, _>>().ok()
}

/// What Windows-1252 has at 0x80 to 0x9F; `\0` where it has nothing.
const WINDOWS: [char; 32] = [
    '€', '\0', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\0', 'Ž', '\0', '\0', '‘',
    '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\0', 'ž', 'Ÿ',
];

fn windows_1252(bytes: &[u8], name: &str) -> Result<String, CohortError> {
    let mut text = String::with_capacity(bytes.len() + bytes.len() / 8);
    for (at, byte) in bytes.iter().enumerate() {
        let mark = match byte {
            0x80..=0x9F => WINDOWS[usize::from(byte - 0x80)],
            byte => char::from(*byte),
        };
        if mark == '\0' {
            let row = 1 + bytes[..at].iter().filter(|byte| **byte == b'\n').count();
            let reason = "neither UTF-8 nor Windows-1252; save the file as UTF-8";
            return Err(CohortError::at(Place::row(name, row), reason));
        }
        text.push(mark);
    }
    Ok(text)
}

/// The separator and the number of lines above the header.
fn header<'a>(text: &'a str, separators: &[u8], wanted: &[&str]) -> (u8, usize) {
    let exactly: BTreeSet<&str> = wanted.iter().map(|name| name.trim()).collect();
    let mut but_for_marks: BTreeSet<String> = wanted.iter().map(|name| plain(name)).collect();
    but_for_marks.remove("");
    let is_wanted = |name: &str| exactly.contains(name) || but_for_marks.contains(&plain(name));
    let start = |line: &'a str| &line[..line.floor_char_boundary(LOOKED_AT)];
    let lines: Vec<&str> = text.lines().take(TOP).map(start).collect();
    let mut best = ((0, 0, 0), (separators[0], 0));
    for separator in separators.iter().copied() {
        let split: Vec<Vec<String>> = lines.iter().map(|line| fields(line, separator)).collect();
        let widths: Vec<usize> = split.iter().map(Vec::len).collect();
        for (above, row) in split.iter().enumerate() {
            let known = row.iter().filter(|name| is_wanted(name)).count();
            if row.iter().all(String::is_empty) {
                continue;
            }
            // A header has as many columns as the lines below it, and words in them.
            let like = widths[above..].iter().filter(|width| **width == row.len()).count();
            let named = row.iter().filter(|name| !name.is_empty()).count();
            let like = if row.len() > 1 && 2 * named > row.len() { like } else { 0 };
            // The first line of equals: ties go to the earlier line and separator.
            let fit = (known, like, row.len());
            if fit > best.0 {
                best = (fit, (separator, above));
            }
        }
    }
    best.1
}

/// Whether two column names are the same but for case and marks.
pub(super) fn same(one: &str, other: &str) -> bool {
    one.trim() == other || (!plain(one).is_empty() && plain(one) == plain(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(bytes: &[u8], wanted: &[&str]) -> Result<Opened, CohortError> {
        Opened::of(bytes.to_vec(), "t.csv", wanted)
    }

    #[test]
    fn encodings_separators_and_lines_above_are_found() {
        let utf16: Vec<u8> =
            "\u{feff}zeit\twert\n1\t2\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        for (bytes, says, header) in [
            (&b"a,b\n1,2\n"[..], "UTF-8, columns between commas", ["a", "b"]),
            (b"a;b\r\n1,5;2,5\r\n", "UTF-8, columns between semicolons", ["a", "b"]),
            (
                b"\xEF\xBB\xBFa\tb\n1\t2\n",
                "UTF-8 with a byte-order mark, columns between tabs",
                ["a", "b"],
            ),
            (
                b"caf\xE9|b\n1|2\n",
                "Windows-1252 (not UTF-8), columns between vertical bars",
                ["café", "b"],
            ),
            (&utf16, "UTF-16, columns between tabs", ["zeit", "wert"]),
            (b"a;b\r1;2\r", "UTF-8, columns between semicolons", ["a", "b"]),
            (
                b"My export\nmade 1, 2, 3\n\na,b\n1,2\n3,4\n",
                "UTF-8, columns between commas, header in line 4",
                ["a", "b"],
            ),
        ] {
            let opened = open(bytes, &[]).expect("a table");
            assert_eq!(opened.form, says);
            assert_eq!(opened.table.header(), header);
        }
    }

    #[test]
    fn a_known_column_decides_which_line_is_the_header() {
        let text = b"x;y;z\n1;2;3\nTime;Glucose\n1,5;2,5\n";
        let error = open(text, &[]).expect_err("the first line is taken");
        assert!(error.to_string().contains("row 3: 2 fields where the header has 3"), "{error}");
        let opened = open(text, &["time"]).expect("a table");
        assert_eq!(opened.table.header(), ["Time", "Glucose"]);
        assert_eq!(opened.table.place(0).to_string(), "t.csv, row 4");
    }

    #[test]
    fn what_is_no_text_is_said() {
        for (bytes, says) in [
            (&b"\xD0\xCF\x11\xE0..."[..], "save the sheet as .xlsx or CSV"),
            (b"a,b\n1,\x002\n", "t.csv, row 2: a zero byte"),
            (b"a,b\n1,\x81\n", "t.csv, row 2: neither UTF-8 nor"),
            (b"\xFF\xFEa", "damaged UTF-16"),
            (b"", "no data row"),
        ] {
            let error = open(bytes, &[]).expect_err("refused").to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
