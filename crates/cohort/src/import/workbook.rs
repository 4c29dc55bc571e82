//! Sheets of an Excel workbook (`.xlsx`), row by row.
//!
//! A small archive can unpack to any size, so that every part is unpacked once and counted before
//! it is read. Rows are streamed; a sheet is never in memory as a whole.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use calamine::{DataRef, Reader as _, Sheet, SheetVisible, Xlsx, XlsxError};
use chrono::{NaiveDate, NaiveDateTime, NaiveTime, TimeDelta};
use zip::ZipArchive;

use crate::error::{CohortError, Place, shorten};
use crate::text_table::MOST_COLUMNS;

/// How an archive begins, and therefore a workbook.
const MARK: &[u8] = b"PK\x03\x04";
/// Largest workbook, bytes: Tidepool's of ten years has some 100 MB.
const LARGEST_FILE: u64 = 512 << 20;
/// Most bytes of all parts together, unpacked.
const LARGEST_UNPACKED: u64 = 4 << 30;
/// Most bytes of a part that is held in memory (texts shared by cells, styles), unpacked.
const LARGEST_HELD: u64 = 64 << 20;
/// Most parts: a workbook has a few for each sheet.
const MOST_PARTS: u16 = 4096;
/// Longest piece between two marks of a sheet, bytes; a cell has at most 32,767 letters.
const LONGEST_PIECE: usize = 1 << 20;
/// Longest text of a cell, bytes: 32,767 letters.
const LONGEST_CELL: usize = 4 * 32_767;
/// Rows of the longest sheet.
const MOST_ROWS: u32 = 1 << 20;
/// Bytes unpacked at a time.
const PIECE: usize = 1 << 16;

/// What a cell holds.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell<'a> {
    /// A text.
    Text(Cow<'a, str>),
    /// A number.
    Number(f64),
    /// A date with its time of day.
    Time(NaiveDateTime),
    /// A time of day, or a duration, in milliseconds.
    Clock(i64),
}

impl Cell<'_> {
    /// The cell as a table of text writes it.
    pub(super) fn text(&self) -> Cow<'_, str> {
        match self {
            Self::Text(text) => Cow::Borrowed(text.trim()),
            Self::Number(number) => Cow::Owned(number.to_string()),
            Self::Time(time) => Cow::Owned(time.format("%Y-%m-%d %H:%M:%S%.f").to_string()),
            Self::Clock(millis) => {
                let (sign, seconds) = (if *millis < 0 { "-" } else { "" }, millis.abs() / 1000);
                let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
                Cow::Owned(format!("{sign}{hours:02}:{minutes:02}:{:02}", seconds % 60))
            }
        }
    }
}

/// Whether a person who opens the workbook sees a sheet.
pub(super) fn is_visible(sheet: &Sheet) -> bool {
    sheet.visible == SheetVisible::Visible
}

/// An open workbook.
pub(super) struct Workbook {
    /// The file's name in messages.
    name: String,
    book: Xlsx<BufReader<File>>,
}

/// Whether a file begins as a workbook does. What cannot be read is left for its reader to refuse.
pub(super) fn is_archive(path: &Path) -> bool {
    let mut start = [0; MARK.len()];
    path.is_file()
        && File::open(path).and_then(|mut file| file.read_exact(&mut start)).is_ok()
        && start == MARK
}

impl Workbook {
    /// Opens a workbook whose parts have been counted; messages call it `name`.
    pub(super) fn open(path: &Path, name: &str) -> Result<Self, CohortError> {
        let failed = CohortError::io(name, "read");
        let mut file = File::open(path).map_err(failed)?;
        if !file.metadata().map_err(failed)?.is_file() {
            let reason = "not a file; a file is needed";
            return Err(CohortError::at(Place::file(name), reason));
        }
        guarded(name, || count(&mut file, name))?;
        file.rewind().map_err(failed)?;
        let book = guarded(name, || {
            Xlsx::new(BufReader::with_capacity(PIECE, file)).map_err(|error| damaged(name, &error))
        })?;
        Ok(Self { name: name.into(), book })
    }

    /// The sheets in their order.
    pub(super) fn sheets(&self) -> Vec<Sheet> {
        self.book.sheets_metadata().to_vec()
    }

    /// Calls `each` with the number (from 1) and the cells of every row that has one: the column
    /// (from 0) and what it holds.
    pub(super) fn rows(
        &mut self,
        sheet: &str,
        mut each: impl FnMut(usize, &[(usize, Cell<'_>)]) -> Result<(), CohortError>,
    ) -> Result<(), CohortError> {
        let name = format!("{}, sheet {sheet}", self.name);
        let zero_is_1904 = self.book.has_1904_epoch();
        let book = &mut self.book;
        guarded(&name, || {
            let wrong = |error| damaged(&name, &error);
            let mut cells = book.worksheet_cells_reader(sheet).map_err(wrong)?;
            let (mut row, mut held) = (0, Vec::new());
            while let Some(cell) = cells.next_cell().map_err(wrong)? {
                let (at, column) = cell.get_position();
                if at != row {
                    if at < row || at >= MOST_ROWS {
                        let reason = "rows are not in their order; save the workbook again";
                        return Err(CohortError::table(&name, reason));
                    }
                    if !held.is_empty() {
                        each(row as usize + 1, &held)?;
                    }
                    (row, held) = (at, Vec::new());
                }
                let place = || Place::row(&name, row as usize + 1);
                if let Some(cell) = read(cell.get_value(), zero_is_1904, place)? {
                    if column as usize >= MOST_COLUMNS {
                        let what = format!("more than {MOST_COLUMNS} columns");
                        let remedy = "a row is a time and a column a quantity";
                        return Err(CohortError::too_large(&name, what, remedy));
                    }
                    held.push((column as usize, cell));
                }
            }
            if held.is_empty() { Ok(()) } else { each(row as usize + 1, &held) }
        })
    }
}

/// What a cell holds; `None` for an empty one.
fn read<'a>(
    value: &DataRef<'a>,
    zero_is_1904: bool,
    place: impl Fn() -> Place,
) -> Result<Option<Cell<'a>>, CohortError> {
    let text = |text: Cow<'a, str>| {
        if text.len() > LONGEST_CELL {
            let reason = "a cell of more than 32,767 letters; remove it";
            return Err(CohortError::at(place(), reason));
        }
        Ok((!text.trim().is_empty()).then_some(Cell::Text(text)))
    };
    Ok(match value {
        DataRef::Empty => None,
        DataRef::Int(number) => Some(Cell::Number(*number as f64)),
        DataRef::Float(number) => Some(Cell::Number(*number)),
        DataRef::String(owned) | DataRef::DateTimeIso(owned) | DataRef::DurationIso(owned) => {
            return text(Cow::Owned(owned.clone()));
        }
        DataRef::SharedString(shared) => return text(Cow::Borrowed(shared)),
        DataRef::Bool(flag) => Some(Cell::Number(f64::from(u8::from(*flag)))),
        DataRef::DateTime(time) => {
            let days = time.as_f64();
            if time.is_duration() || (0.0..1.0).contains(&days) {
                Some(Cell::Clock((days.clamp(-1e6, 1e6) * 86_400_000.0).round() as i64))
            } else {
                let days = if zero_is_1904 { days + 1462.0 } else { days };
                Some(from_days(days).map_or(Cell::Number(time.as_f64()), Cell::Time))
            }
        }
        // `#N/A` and the like are left for the reader of the column to refuse.
        DataRef::Error(error) => Some(Cell::Text(Cow::Owned(error.to_string()))),
    })
}

/// The time of days since 1900 as Excel counts them, to the millisecond; `None` outside 1900 to 2199.
pub(super) fn from_days(days: f64) -> Option<NaiveDateTime> {
    // Excel has a 29 February 1900.
    let days = if days < 60.0 { days + 1.0 } else { days };
    let zero = NaiveDate::from_ymd_opt(1899, 12, 30)?.and_time(NaiveTime::MIN);
    let millis = (0.0..110_000.0).contains(&days).then(|| (days * 86_400_000.0).round() as i64)?;
    zero.checked_add_signed(TimeDelta::milliseconds(millis))
}

/// Unpacks every part and counts its bytes.
fn count(file: &mut File, name: &str) -> Result<(), CohortError> {
    let failed = CohortError::io(name, "read");
    let size = file.metadata().map_err(failed)?.len();
    if size > LARGEST_FILE {
        return Err(large(name, format!("{size} bytes, more than {LARGEST_FILE}")));
    }
    parts(file, size, name).map_err(failed)??;
    file.rewind().map_err(failed)?;
    let broken = |error: zip::result::ZipError| {
        let reason = format!("the workbook is damaged or cut off ({error}); download it again");
        CohortError::table(name, reason)
    };
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(broken)?;
    if !archive.file_names().any(|part| part.is_ok_and(|part| part.starts_with("xl/"))) {
        let reason = "a ZIP archive without an Excel workbook; unpack it, or save the sheet as \
                      .xlsx or CSV";
        return Err(CohortError::at(Place::file(name), reason));
    }
    let (mut buffer, mut all) = (vec![0; PIECE], 0);
    for i in 0..archive.len() {
        let mut part = archive.by_index(i).map_err(broken)?;
        let title = shorten(&part.name().map_err(broken)?, 80);
        let is_sheet = title.to_lowercase().contains("worksheets/");
        let (mut unpacked, mut piece, mut last) = (0, 0, 0);
        loop {
            let read = part.read(&mut buffer).map_err(|error| {
                let reason =
                    format!("part '{title}' cannot be unpacked ({error}); download it again");
                CohortError::table(name, reason)
            })?;
            if read == 0 {
                break;
            }
            unpacked += read as u64;
            all += read as u64;
            if all > LARGEST_UNPACKED || !is_sheet && unpacked > LARGEST_HELD {
                return Err(large(name, format!("part '{title}' unpacks to too much")));
            }
            if !is_sheet {
                continue;
            }
            for byte in &buffer[..read] {
                piece = if *byte == b'<' { 0 } else { piece + 1 };
                // Comments and quoted sections have no end that a reader could be sure of.
                if piece > LONGEST_PIECE || last == b'<' && *byte == b'!' {
                    let reason = "a sheet that no spreadsheet program writes; save it as CSV";
                    return Err(CohortError::table(name, reason));
                }
                last = *byte;
            }
        }
    }
    Ok(())
}

/// Looks at the number of parts, which stands at the end of the file.
fn parts(file: &mut File, size: u64, name: &str) -> std::io::Result<Result<(), CohortError>> {
    // The last record has 22 bytes and a remark of at most 65,535.
    let tail = size.min(65_557);
    file.seek(SeekFrom::Start(size - tail))?;
    let mut bytes = Vec::new();
    file.take(tail).read_to_end(&mut bytes)?;
    let ends = bytes.windows(12).filter(|end| end.starts_with(b"PK\x05\x06"));
    let most = ends.map(|end| u16::from_le_bytes([end[10], end[11]])).max();
    let far = bytes.windows(4).any(|four| four == b"PK\x06\x07");
    Ok(match most {
        None => {
            Err(CohortError::table(name, "not an Excel workbook, or cut off; download it again"))
        }
        Some(most) if most > MOST_PARTS || far => {
            Err(large(name, format!("more than {MOST_PARTS} parts")))
        }
        Some(_) => Ok(()),
    })
}

/// The error of a workbook that is too large.
fn large(name: &str, what: String) -> CohortError {
    let remedy = "this is no workbook of one person; save what is needed as CSV";
    CohortError::too_large(name, what, remedy)
}

/// The error of a workbook that the library cannot read.
fn damaged(name: &str, error: &XlsxError) -> CohortError {
    let reason = format!("{error}; save it again in a spreadsheet program, or as CSV");
    CohortError::table(name, reason)
}

/// Runs what the library does; should it panic on a damaged file, that becomes an error.
fn guarded<T>(name: &str, run: impl FnOnce() -> Result<T, CohortError>) -> Result<T, CohortError> {
    catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|_| {
        Err(CohortError::table(name, "damaged, or of a kind that cannot be read; save it as CSV"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_of_excel_are_times() {
        let at = |days| from_days(days).map(|time| time.to_string());
        assert_eq!(at(45_352.333_796_296_3).as_deref(), Some("2024-03-01 08:00:40"));
        assert_eq!(at(61.0).as_deref(), Some("1900-03-01 00:00:00"));
        assert_eq!(at(1.0).as_deref(), Some("1900-01-01 00:00:00"));
        assert_eq!((at(1e300), at(-5.0), at(f64::NAN)), (None, None, None));
    }

    #[test]
    fn cells_are_written_as_in_a_table() {
        let time = from_days(45_352.25).expect("a time");
        for (cell, text) in [
            (Cell::Text(" a ".into()), "a"),
            (Cell::Number(5.0), "5"),
            (Cell::Number(0.075), "0.075"),
            (Cell::Time(time), "2024-03-01 06:00:00"),
            (Cell::Clock(29_100_000), "08:05:00"),
        ] {
            assert_eq!(cell.text(), text);
        }
    }
}
