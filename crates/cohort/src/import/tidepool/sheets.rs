//! The workbook that Tidepool's site exports: a sheet for each type of data, a datum a row.
//!
//! Names of sheets and columns, durations in minutes and the sheet that an interrupted export shows
//! are those of the package `@tidepool/data-tools` 2.5 (`config.json`, `xlsxStreamWriter`), which
//! `tidepool-org/export` calls. Sheets without a type of data (schedules, uploads) are not read.

use serde_json::{Map, Number, Value};

use super::{INCOMPLETE, Reader};
use crate::error::{CohortError, Place};
use crate::import::json_records::JsonRecord;
use crate::import::workbook::{Cell, Workbook, from_days, is_visible};

/// The columns that are read, and their keys in Tidepool's data.
const COLUMNS: [(&str, &str); 17] = [
    ("Zulu Time", "time"),
    ("Device Time", "deviceTime"),
    ("Tidepool Data Type", "type"),
    ("Tidepool Wizard Type", "type"),
    ("Id", "id"),
    ("Timezone Offset", "timezoneOffset"),
    ("Value", "value"),
    ("Units", "units"),
    ("Delivery Type", "deliveryType"),
    ("Duration (mins)", "duration"),
    ("Rate", "rate"),
    ("Sub Type", "subType"),
    ("Normal", "normal"),
    ("Extended", "extended"),
    ("Carb Input", "carbInput"),
    ("Nutrition", "nutrition"),
    ("Prime Target", "primeTarget"),
];
/// The sheet that a person sees only where the export was interrupted.
const ERROR: &str = "EXPORT ERROR";
/// Keys of an instant, and of a local time.
const TIMES: [&str; 2] = ["time", "deviceTime"];

/// Reads every sheet with a column for the type of data.
pub(super) fn read(
    book: &mut Workbook,
    name: &str,
    reader: &mut Reader,
) -> Result<(), CohortError> {
    let mut any = false;
    for sheet in book.sheets() {
        if sheet.name == ERROR {
            if is_visible(&sheet) {
                reader.diary.note(INCOMPLETE, || Place::file(format!("{name}, sheet {ERROR}")));
            }
            continue;
        }
        let file = format!("{name}, sheet {}", sheet.name);
        let mut keys: Vec<Option<&str>> = Vec::new();
        book.rows(&sheet.name, |row, cells| {
            if row == 1 {
                keys = header(cells);
                any |= keys.contains(&Some("type"));
            } else if keys.contains(&Some("type")) {
                let fields = cells.iter().filter_map(|(column, cell)| {
                    let key = keys.get(*column).copied().flatten()?;
                    Some((key.to_owned(), value(key, cell)))
                });
                let fields: Map<String, Value> = fields.collect();
                let columns = &COLUMNS;
                reader.read(&JsonRecord { file: &file, number: row, fields, columns })?;
            }
            Ok(())
        })?;
    }
    if any {
        return Ok(());
    }
    let reason = "no sheet has a column 'Tidepool Data Type' in its first row";
    Err(CohortError::layout(name, super::FORMAT, reason))
}

/// The key of each column; `None` for those that are not read.
fn header(cells: &[(usize, Cell<'_>)]) -> Vec<Option<&'static str>> {
    let mut keys = Vec::new();
    for (column, cell) in cells {
        keys.resize(keys.len().max(column + 1), None);
        let text = cell.text();
        keys[*column] = COLUMNS.iter().find(|(name, _)| *name == text).map(|(_, key)| *key);
    }
    keys
}

/// A cell as Tidepool's data have it. A time that lost its format is a number of days.
fn value(key: &str, cell: &Cell<'_>) -> Value {
    let time = match cell {
        Cell::Time(time) => Some(*time),
        Cell::Number(days) if TIMES.contains(&key) => from_days(*days),
        _ => None,
    };
    match (time, cell) {
        (Some(time), _) => {
            let zone = if key == TIMES[0] { "Z" } else { "" };
            Value::String(format!("{}{zone}", time.format("%Y-%m-%dT%H:%M:%S%.3f")))
        }
        (None, Cell::Number(number)) => {
            Number::from_f64(*number).map_or(Value::Null, Value::Number)
        }
        (None, cell) => Value::String(cell.text().into_owned()),
    }
}
