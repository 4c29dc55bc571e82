//! The table of records, as text or as Parquet, before it is put on the grid.

use std::fs::File;
use std::path::Path;

use chrono::{DateTime, NaiveDateTime};
use polars::prelude::{
    DataFrame, DataType, Float64Chunked, Int64Chunked, ParquetReader, PolarsError, SerReader as _,
    StringChunked, TimeUnit,
};

use super::columns::check_names;
use super::{RECORDS_CSV, RECORDS_PARQUET, RecordsFormat};
use crate::error::{CohortError, Place};
use crate::faults::Faults;
use crate::parquet_footer;
use crate::parquet_frame::{fault, frame, guarded};
use crate::parquet_pages;
use crate::person::{ID_EXPECTED, is_person_id};
use crate::record::Channel;
use crate::text_table::{MOST_COLUMNS, TextTable};
use crate::wall_clock::parse_iso;

pub(super) const PERSON_ID: &str = "person_id";
pub(super) const TIME: &str = "time";
const TIME_EXPECTED: &str = "a local time like 2024-03-01T08:05:00 without a zone";

/// Most rows of a Parquet file; looked at before any column is read.
const MOST_ROWS: usize = 1 << 25;

/// The records as they are in the file.
pub(super) enum RecordTable {
    /// Text cells, with the index in the header of the identifier, the time and each channel.
    Csv { table: TextTable, keys: [usize; 2], channels: Vec<Option<usize>> },
    /// Typed columns.
    Parquet(Box<ParquetTable>),
}

/// The columns of a Parquet file, checked for their types.
pub(super) struct ParquetTable {
    header: Vec<String>,
    person: StringChunked,
    time: ParquetTime,
    channels: [Option<Float64Chunked>; Channel::ALL.len()],
}

enum ParquetTime {
    Text(StringChunked),
    Epoch(Int64Chunked, TimeUnit),
}

/// The columns that a file of records can have; the first three must be there.
pub(super) fn columns() -> Vec<&'static str> {
    [PERSON_ID, TIME].into_iter().chain(Channel::ALL.map(Channel::name)).collect()
}

impl RecordTable {
    /// Reads the file of records and checks that the columns that must be there are.
    pub(super) fn read(
        folder: &Path,
        format: RecordsFormat,
        faults: &mut Faults,
    ) -> Result<Self, CohortError> {
        let path = folder.join(format.file());
        match format {
            RecordsFormat::Csv => {
                let table = TextTable::check(&path, RECORDS_CSV, b',', faults)?;
                check_names(RECORDS_CSV, table.header(), &columns(), faults)?;
                let keys = [table.index(PERSON_ID)?, table.index(TIME)?];
                table.index(Channel::Cgm.name())?;
                let channels = Channel::ALL.iter().map(|one| table.index(one.name()).ok());
                Ok(Self::Csv { keys, channels: channels.collect(), table })
            }
            RecordsFormat::Parquet => {
                Ok(Self::Parquet(Box::new(ParquetTable::read(&path, faults)?)))
            }
        }
    }

    /// The names of the columns.
    pub(super) fn header(&self) -> &[String] {
        match self {
            Self::Csv { table, .. } => table.header(),
            Self::Parquet(table) => &table.header,
        }
    }

    /// Number of rows.
    pub(super) fn height(&self) -> usize {
        match self {
            Self::Csv { table, .. } => table.height(),
            Self::Parquet(table) => table.person.len(),
        }
    }

    /// The file's name.
    pub(super) const fn file(&self) -> &'static str {
        match self {
            Self::Csv { .. } => RECORDS_CSV,
            Self::Parquet(_) => RECORDS_PARQUET,
        }
    }

    /// A cell, for messages.
    pub(super) fn cell(&self, i: usize, column: &str) -> Place {
        let row = match self {
            Self::Csv { table, .. } => table.place(i),
            Self::Parquet(_) => Place::row(RECORDS_PARQUET, i + 1),
        };
        Place { column: Some(column.into()), ..row }
    }

    /// Person and time of row `i`.
    pub(super) fn row(&self, i: usize) -> Result<(&str, NaiveDateTime), CohortError> {
        let (person, written, time) = match self {
            Self::Csv { table, keys, .. } => {
                let [person, time] = keys.map(|key| table.cell(i, key).unwrap_or(""));
                (person, time, parse_iso(time))
            }
            Self::Parquet(table) => {
                let person = table.person.get(i).unwrap_or("");
                match &table.time {
                    ParquetTime::Text(cells) => {
                        let time = cells.get(i).unwrap_or("");
                        (person, time, parse_iso(time))
                    }
                    ParquetTime::Epoch(cells, unit) => {
                        (person, "", cells.get(i).and_then(|value| epoch(value, *unit)))
                    }
                }
            }
        };
        let wrong =
            |column, text, expected| CohortError::cell(self.cell(i, column), text, expected);
        if !is_person_id(person) {
            return Err(wrong(PERSON_ID, person, ID_EXPECTED));
        }
        Ok((person, time.ok_or_else(|| wrong(TIME, written, TIME_EXPECTED))?))
    }

    /// The number of a channel in row `i`; `None` where the cell is empty or the column absent.
    pub(super) fn number(&self, i: usize, channel: Channel) -> Result<Option<f64>, CohortError> {
        match self {
            Self::Csv { table, channels, .. } => match channels[channel as usize] {
                Some(column) => table.column_at(column).number(i),
                None => Ok(None),
            },
            Self::Parquet(table) => {
                let cells = table.channels[channel as usize].as_ref();
                let value = cells.and_then(|cells| cells.get(i));
                let Some(value) = value.filter(|value| !value.is_finite()) else {
                    return Ok(value);
                };
                let expected = "a finite number; write null if it is unknown";
                let place = self.cell(i, channel.name());
                Err(CohortError::cell(place, &value.to_string(), expected))
            }
        }
    }
}

impl ParquetTable {
    /// Reads a Parquet file. Number and names of its columns and rows are looked at before any of
    /// them is read, and only known columns are. What its pages claim is looked at first.
    fn read(path: &Path, faults: &mut Faults) -> Result<Self, CohortError> {
        let open = || File::open(path).map_err(CohortError::io(RECORDS_PARQUET, "read"));
        parquet_footer::check(open()?, RECORDS_PARQUET)?;
        let (file, again) = (open()?, open()?);
        let header = guarded(RECORDS_PARQUET, || header(file))?;
        check_names(RECORDS_PARQUET, &header, &columns(), faults)?;
        let wanted = columns().into_iter().map(str::to_owned);
        let wanted: Vec<String> = wanted.filter(|name| header.contains(name)).collect();
        parquet_pages::check(&mut open()?, RECORDS_PARQUET, &wanted)?;
        let reader = ParquetReader::new(again).with_columns(Some(wanted));
        guarded(RECORDS_PARQUET, || Self::new(&frame(RECORDS_PARQUET, reader)?, header))
    }

    fn new(frame: &DataFrame, header: Vec<String>) -> Result<Self, CohortError> {
        if frame.height() == 0 {
            return Err(CohortError::empty(RECORDS_PARQUET));
        }
        let find = |name: &str| {
            let column = frame.columns().iter().find(|column| column.name().as_str() == name);
            column.ok_or_else(|| CohortError::missing_column(RECORDS_PARQUET, name, &header))
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
            let name = channel.name();
            let column = match find(name) {
                Err(_) if channel != Channel::Cgm => continue,
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
            person: person.str().map_err(broken)?.rechunk().into_owned(),
            header,
            time,
            channels,
        })
    }
}

/// The names of the columns, if rows and columns are as many as a study can have.
fn header(file: File) -> Result<Vec<String>, CohortError> {
    let too_large = |what: String| {
        CohortError::too_large(RECORDS_PARQUET, what, "split the cohort into folders")
    };
    let mut reader = ParquetReader::new(file);
    let metadata = reader.get_metadata().map_err(broken)?;
    let of_groups = metadata.row_groups.iter().map(|group| group.num_rows()).sum();
    let rows = metadata.num_rows.max(of_groups);
    if rows > MOST_ROWS {
        return Err(too_large(format!("{rows} rows, more than {MOST_ROWS}")));
    }
    let schema = reader.schema().map_err(broken)?;
    if schema.len() > MOST_COLUMNS {
        return Err(too_large(format!("{} columns, more than {MOST_COLUMNS}", schema.len())));
    }
    Ok(schema.iter_names().map(ToString::to_string).collect())
}

fn broken(error: PolarsError) -> CohortError {
    fault(RECORDS_PARQUET)(error)
}

fn epoch(value: i64, unit: TimeUnit) -> Option<NaiveDateTime> {
    let time = match unit {
        TimeUnit::Milliseconds => DateTime::from_timestamp_millis(value)?,
        TimeUnit::Microseconds => DateTime::from_timestamp_micros(value)?,
        TimeUnit::Nanoseconds => DateTime::from_timestamp_nanos(value),
    };
    Some(time.naive_utc())
}
