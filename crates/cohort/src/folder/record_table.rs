//! The table of records, as text or as Parquet, before it is put on the grid.

use std::io::Cursor;
use std::path::Path;

use chrono::{DateTime, NaiveDateTime};
use polars::prelude::{
    DataFrame, DataType, Float64Chunked, Int64Chunked, ParquetReader, PolarsError, SerReader,
    StringChunked, TimeUnit,
};

use super::people_table::person_id;
use super::{RECORDS_CSV, RECORDS_PARQUET, RecordsFormat};
use crate::error::{CohortError, Place};
use crate::person::is_person_id;
use crate::record::Channel;
use crate::text_table::{TextTable, read_bytes, shorten};
use crate::wall_clock::parse_iso;

pub(super) const PERSON_ID: &str = "person_id";
pub(super) const TIME: &str = "time";
const TIME_EXPECTED: &str = "a local time like 2024-03-01T08:05:00 without a zone";

/// The records as they are in the file.
pub(super) enum RecordTable {
    /// Text cells.
    Csv(TextTable),
    /// Typed columns.
    Parquet(Box<ParquetTable>),
}

/// The columns of a Parquet file, checked for their types.
pub(super) struct ParquetTable {
    height: usize,
    person: StringChunked,
    time: ParquetTime,
    channels: [Option<Float64Chunked>; Channel::ALL.len()],
}

enum ParquetTime {
    Text(StringChunked),
    Epoch(Int64Chunked, TimeUnit),
}

impl RecordTable {
    /// Reads the file of records and checks that every column is there.
    pub(super) fn read(folder: &Path, format: RecordsFormat) -> Result<Self, CohortError> {
        let path = folder.join(format.file());
        match format {
            RecordsFormat::Csv => {
                let table = TextTable::read(&path, RECORDS_CSV, b',')?;
                table.column(PERSON_ID)?;
                table.column(TIME)?;
                for channel in Channel::ALL {
                    if channel != Channel::SetChange {
                        table.column(channel.column())?;
                    }
                }
                Ok(Self::Csv(table))
            }
            RecordsFormat::Parquet => {
                let table = ParquetTable::read(read_bytes(&path, RECORDS_PARQUET)?)?;
                Ok(Self::Parquet(Box::new(table)))
            }
        }
    }

    /// Number of rows.
    pub(super) fn height(&self) -> usize {
        match self {
            Self::Csv(table) => table.height(),
            Self::Parquet(table) => table.height,
        }
    }

    /// The file's name.
    pub(super) fn file(&self) -> &str {
        match self {
            Self::Csv(table) => table.file(),
            Self::Parquet(_) => RECORDS_PARQUET,
        }
    }

    /// A row, for messages.
    pub(super) fn place(&self, i: usize) -> Place {
        match self {
            Self::Csv(table) => table.place(i),
            Self::Parquet(_) => Place::row(RECORDS_PARQUET, i + 1),
        }
    }

    /// A cell, for messages.
    pub(super) fn cell(&self, i: usize, column: &str) -> Place {
        Place { column: Some(column.into()), ..self.place(i) }
    }

    /// Calls `see` with each row's index, person and time, in the order of the file.
    pub(super) fn rows(
        &self,
        mut see: impl FnMut(usize, &str, NaiveDateTime) -> Result<(), CohortError>,
    ) -> Result<(), CohortError> {
        match self {
            Self::Csv(table) => {
                let (people, times) = (table.column(PERSON_ID)?, table.column(TIME)?);
                for i in 0..table.height() {
                    let time = times
                        .text(i)
                        .and_then(parse_iso)
                        .ok_or_else(|| times.wrong(i, TIME_EXPECTED))?;
                    see(i, person_id(&people, i)?, time)?;
                }
            }
            Self::Parquet(table) => {
                for i in 0..table.height {
                    let wrong = |column, value: &str, expected| CohortError::Cell {
                        place: self.cell(i, column),
                        value: shorten(value, 40),
                        expected,
                    };
                    let person = table.person.get(i).unwrap_or("");
                    if !is_person_id(person) {
                        return Err(wrong(PERSON_ID, person, "a person's identifier"));
                    }
                    let time = match &table.time {
                        ParquetTime::Text(cells) => cells
                            .get(i)
                            .and_then(parse_iso)
                            .ok_or_else(|| wrong(TIME, cells.get(i).unwrap_or(""), TIME_EXPECTED)),
                        ParquetTime::Epoch(cells, unit) => cells
                            .get(i)
                            .and_then(|value| epoch(value, *unit))
                            .ok_or_else(|| wrong(TIME, "", TIME_EXPECTED)),
                    }?;
                    see(i, person, time)?;
                }
            }
        }
        Ok(())
    }

    /// A channel's cells, read one at a time; `None` for an optional column that is absent.
    pub(super) fn channel<'a>(
        &'a self,
        channel: Channel,
    ) -> Result<Option<NumberCells<'a>>, CohortError> {
        match self {
            Self::Csv(table) => {
                let Some(column) = table.optional(channel.column())? else { return Ok(None) };
                Ok(Some(Box::new(move |i| column.number(i))))
            }
            Self::Parquet(table) => {
                let Some(cells) = &table.channels[channel as usize] else { return Ok(None) };
                Ok(Some(Box::new(move |i| match cells.get(i) {
                    Some(value) if !value.is_finite() => Err(CohortError::Cell {
                        place: self.cell(i, channel.column()),
                        value: value.to_string(),
                        expected: "a finite number; write null if it is unknown",
                    }),
                    value => Ok(value),
                })))
            }
        }
    }
}

/// Reads the number in a row, `None` where the cell is empty.
pub(super) type NumberCells<'a> = Box<dyn Fn(usize) -> Result<Option<f64>, CohortError> + 'a>;

impl ParquetTable {
    /// Reads a Parquet file. The table library panics on some damaged files; here that is an error
    /// like any other (the library's own message still goes to the panic hook). Damage to the
    /// length of a page can still exhaust the memory inside the library.
    fn read(bytes: Vec<u8>) -> Result<Self, CohortError> {
        const MARK: &[u8] = b"PAR1";
        let damaged = |reason: &str| CohortError::Table {
            file: RECORDS_PARQUET.into(),
            reason: reason.into(),
        };
        if !(bytes.len() > 2 * MARK.len() && bytes.starts_with(MARK) && bytes.ends_with(MARK)) {
            return Err(damaged("it does not begin and end as Parquet does; it may be cut off"));
        }
        let parse = move || {
            let frame = ParquetReader::new(Cursor::new(bytes)).finish().map_err(broken)?;
            Self::new(&frame)
        };
        std::panic::catch_unwind(parse)
            .unwrap_or_else(|_| Err(damaged("it is damaged; write it again from its source")))
    }

    fn new(frame: &DataFrame) -> Result<Self, CohortError> {
        if frame.height() == 0 {
            return Err(CohortError::Empty { file: RECORDS_PARQUET.into() });
        }
        let find = |name: &str| {
            frame.columns().iter().find(|column| column.name().as_str() == name).ok_or_else(|| {
                let names: Vec<&str> =
                    frame.columns().iter().map(|column| column.name().as_str()).collect();
                CohortError::MissingColumn {
                    file: RECORDS_PARQUET.into(),
                    column: name.into(),
                    found: shorten(&names.join(", "), 160),
                }
            })
        };
        let unfit = |name: &str, dtype: &DataType, expected| CohortError::Cell {
            place: Place::column(RECORDS_PARQUET, name),
            value: format!("type {dtype}"),
            expected,
        };
        let person = find(PERSON_ID)?;
        if *person.dtype() != DataType::String {
            return Err(unfit(PERSON_ID, person.dtype(), "a column of strings"));
        }
        let time = find(TIME)?;
        let time = match time.dtype() {
            DataType::String => {
                ParquetTime::Text(time.str().map_err(broken)?.rechunk().into_owned())
            }
            DataType::Datetime(unit, None) => {
                let unit = *unit;
                let epochs = time.cast(&DataType::Int64).map_err(broken)?;
                ParquetTime::Epoch(epochs.i64().map_err(broken)?.rechunk().into_owned(), unit)
            }
            dtype => {
                return Err(unfit(TIME, dtype, "a column of strings or of times without a zone"));
            }
        };
        let mut channels = [const { None }; Channel::ALL.len()];
        for channel in Channel::ALL {
            let name = channel.column();
            let column = match find(name) {
                Err(_) if channel == Channel::SetChange => continue,
                column => column?,
            };
            if !(column.dtype().is_primitive_numeric() || column.dtype().is_null()) {
                return Err(unfit(name, column.dtype(), "a column of numbers"));
            }
            let numbers = column.cast(&DataType::Float64).map_err(broken)?;
            channels[channel as usize] =
                Some(numbers.f64().map_err(broken)?.rechunk().into_owned());
        }
        Ok(Self {
            height: frame.height(),
            person: person.str().map_err(broken)?.rechunk().into_owned(),
            time,
            channels,
        })
    }
}

fn broken(error: PolarsError) -> CohortError {
    CohortError::Table { file: RECORDS_PARQUET.into(), reason: error.to_string() }
}

fn epoch(value: i64, unit: TimeUnit) -> Option<NaiveDateTime> {
    let time = match unit {
        TimeUnit::Milliseconds => DateTime::from_timestamp_millis(value)?,
        TimeUnit::Microseconds => DateTime::from_timestamp_micros(value)?,
        TimeUnit::Nanoseconds => DateTime::from_timestamp_nanos(value),
    };
    Some(time.naive_utc())
}
