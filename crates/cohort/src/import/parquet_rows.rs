//! A Parquet file of others, read piece by piece, so that memory does not grow with its rows.

use std::fs::File;
use std::path::Path;

use chrono::{DateTime, NaiveDateTime};
use polars::prelude::{
    Column, DataType, Float64Chunked, Int64Chunked, ParquetReader, PolarsResult, SerReader as _,
    StringChunked, TimeUnit,
};

use crate::error::{CohortError, Place};
use crate::parquet_footer;
use crate::parquet_frame::{fault, frame, guarded};
use crate::parquet_pages;
use crate::wall_clock::parse_iso_start;

/// Rows of a piece.
const PIECE: usize = 250_000;
/// Most rows of a file: 10,000 people for 5 years.
const MOST_ROWS: usize = 5_300_000_000;

/// What a column must hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Text,
    Number,
    Time,
    /// A span of time, in seconds.
    Span,
}

/// A wanted column: its name in either case, what it holds, and whether it must be there.
pub(super) type Wanted = (&'static str, Kind, bool);

enum Cells {
    Text(StringChunked),
    Number(Float64Chunked),
    Epoch(Int64Chunked, i64),
    Absent,
}

/// A row of the file, by the order of the wanted columns.
pub(super) struct ParquetRow<'a> {
    file: &'a str,
    number: usize,
    index: usize,
    wanted: &'a [Wanted],
    cells: &'a [Cells],
}

impl ParquetRow<'_> {
    pub(super) fn place(&self, column: usize) -> Place {
        Place::cell(self.file, self.number, self.wanted[column].0)
    }

    /// A text; `None` if it is missing or empty.
    pub(super) fn text(&self, column: usize) -> Option<&str> {
        match &self.cells[column] {
            Cells::Text(cells) => cells.get(self.index).filter(|text| !text.trim().is_empty()),
            _ => None,
        }
    }

    /// A finite number or seconds; `None` if it is missing.
    pub(super) fn number(&self, column: usize) -> Result<Option<f64>, CohortError> {
        let value = match &self.cells[column] {
            Cells::Number(cells) => cells.get(self.index).filter(|value| !value.is_nan()),
            Cells::Epoch(cells, per_second) => {
                cells.get(self.index).map(|value| value as f64 / *per_second as f64)
            }
            _ => None,
        };
        match value {
            Some(value) if value.is_infinite() => Err(self.wrong(column, "a finite number")),
            value => Ok(value),
        }
    }

    /// A local time.
    pub(super) fn time(&self, column: usize) -> Result<NaiveDateTime, CohortError> {
        let time = match &self.cells[column] {
            Cells::Epoch(cells, per_second) => cells.get(self.index).and_then(|value| {
                DateTime::from_timestamp(value.div_euclid(*per_second), 0).map(|t| t.naive_utc())
            }),
            Cells::Text(cells) => cells.get(self.index).and_then(parse_iso_start),
            _ => None,
        };
        time.ok_or_else(|| self.wrong(column, "a local time like 2024-03-01T08:05:00"))
    }

    pub(super) fn wrong(&self, column: usize, expected: &'static str) -> CohortError {
        let value = match &self.cells[column] {
            Cells::Text(cells) => cells.get(self.index).map(|text| text.to_owned()),
            Cells::Number(cells) => cells.get(self.index).map(|value| value.to_string()),
            Cells::Epoch(cells, _) => cells.get(self.index).map(|value| value.to_string()),
            Cells::Absent => None,
        };
        CohortError::cell(self.place(column), &value.unwrap_or_default(), expected)
    }
}

/// Calls `each` with every row of the file at `path`; messages call it `name`.
pub(super) fn for_each(
    path: &Path,
    name: &str,
    wanted: &[Wanted],
    mut each: impl FnMut(ParquetRow<'_>) -> Result<(), CohortError>,
) -> Result<(), CohortError> {
    let open = || File::open(path).map_err(CohortError::io(name, "read"));
    parquet_footer::check(open()?, name)?;
    let mut reader = ParquetReader::new(open()?);
    let (rows, header) = guarded(name, || {
        let schema = reader.schema().map_err(fault(name))?;
        let header: Vec<String> = schema.iter_names().map(|n| n.to_string()).collect();
        Ok((reader.num_rows().map_err(fault(name))?, header))
    })?;
    if rows == 0 {
        return Err(CohortError::empty(name));
    }
    if rows > MOST_ROWS {
        return Err(CohortError::table(name, format!("{rows} rows; more than any study has")));
    }
    let mut columns = Vec::new();
    for (column, _, required) in wanted {
        let found = header.iter().find(|found| found.eq_ignore_ascii_case(column));
        if found.is_none() && *required {
            return Err(CohortError::missing_column(name, column, &header));
        }
        columns.push(found);
    }
    let selected: Vec<String> = columns.iter().copied().flatten().cloned().collect();
    parquet_pages::check(&mut open()?, name, &selected)?;
    let mut first = 0;
    while first < rows {
        let reader = ParquetReader::new(open()?)
            .with_slice(Some((first, PIECE)))
            .with_columns(Some(selected.clone()))
            .set_low_memory(true)
            .set_rechunk(true);
        let frame = guarded(name, || frame(name, reader))?;
        if frame.height() == 0 {
            return Err(CohortError::table(name, format!("{first} rows were read of {rows}")));
        }
        let mut cells = Vec::with_capacity(wanted.len());
        for ((_, kind, _), column) in wanted.iter().zip(&columns) {
            let Some(column) = column else {
                cells.push(Cells::Absent);
                continue;
            };
            let typed = || typed(frame.column(column)?, *kind);
            let typed = guarded(name, || typed().map_err(fault(name)))?;
            cells.push(typed.map_err(|holds| {
                let wanted = match kind {
                    Kind::Text => "text",
                    Kind::Number => "numbers",
                    Kind::Time => "local times without a zone",
                    Kind::Span => "spans of time or seconds",
                };
                CohortError::table(name, format!("column {column} holds {holds}, not {wanted}"))
            })?);
        }
        for index in 0..frame.height() {
            let number = first + index + 1;
            each(ParquetRow { file: name, number, index, wanted, cells: &cells })?;
        }
        first += frame.height();
    }
    Ok(())
}

/// The cells of a column, or the type that it has instead.
fn typed(column: &Column, kind: Kind) -> PolarsResult<Result<Cells, DataType>> {
    let per_second = |unit: &TimeUnit| match unit {
        TimeUnit::Milliseconds => 1_000,
        TimeUnit::Microseconds => 1_000_000,
        TimeUnit::Nanoseconds => 1_000_000_000,
    };
    Ok(Ok(match (kind, column.dtype()) {
        // A column without any value.
        (_, DataType::Null) => Cells::Absent,
        (Kind::Text, _) => {
            Cells::Text(column.cast(&DataType::String)?.str()?.rechunk().into_owned())
        }
        (Kind::Time, DataType::String) => Cells::Text(column.str()?.rechunk().into_owned()),
        (Kind::Time, DataType::Datetime(unit, None)) | (Kind::Span, DataType::Duration(unit)) => {
            let cells = column.to_physical_repr().i64()?.rechunk().into_owned();
            Cells::Epoch(cells, per_second(unit))
        }
        (Kind::Number | Kind::Span, dtype) if dtype.is_primitive_numeric() || dtype.is_bool() => {
            Cells::Number(column.cast(&DataType::Float64)?.f64()?.rechunk().into_owned())
        }
        (_, other) => return Ok(Err(other.clone())),
    }))
}
