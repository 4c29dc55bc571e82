//! A table written to Parquet in pieces, in memory that does not grow with its length.
//!
//! For tables that are larger than memory: open a sink with names and kinds of columns, and pass it
//! one row group at a time. The same pieces give the same bytes. It knows nothing of cohorts; it is
//! here because only this crate uses the table library.

use std::io::Write;

use polars::io::parquet::write::BatchedWriter;
use polars::prelude::{
    Column, DataFrame, DataType, IntoColumn, NamedFrom, ParquetCompression, ParquetWriter,
    PolarsResult, Schema, Series,
};

use crate::error::CohortError;

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellKind {
    /// Signed integers of 32 bits.
    Integer,
    /// Numbers in single precision, some possibly unknown.
    Number,
    /// Words of a fixed vocabulary.
    Word,
}

/// A column's cells in one piece of the table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// For [`CellKind::Integer`].
    Integers(Vec<i32>),
    /// For [`CellKind::Number`]; `None` is written as null.
    Numbers(Vec<Option<f32>>),
    /// For [`CellKind::Word`].
    Words(Vec<&'static str>),
}

impl Cells {
    fn kind(&self) -> CellKind {
        match self {
            Self::Integers(_) => CellKind::Integer,
            Self::Numbers(_) => CellKind::Number,
            Self::Words(_) => CellKind::Word,
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Integers(cells) => cells.len(),
            Self::Numbers(cells) => cells.len(),
            Self::Words(cells) => cells.len(),
        }
    }

    fn into_column(self, name: &str) -> Column {
        match self {
            Self::Integers(cells) => Series::new(name.into(), cells),
            Self::Numbers(cells) => Series::new(name.into(), cells),
            Self::Words(cells) => Series::new(name.into(), cells),
        }
        .into_column()
    }
}

/// A Parquet table that is being written.
///
/// ```
/// use cohort::{CellKind, Cells, ParquetSink};
///
/// let columns = [("step", CellKind::Integer), ("glucose_mg_dl", CellKind::Number)];
/// let mut bytes = Vec::new();
/// let mut sink = ParquetSink::new("example.parquet", &mut bytes, &columns)?;
/// sink.write(vec![Cells::Integers(vec![0, 1]), Cells::Numbers(vec![Some(120.0), None])])?;
/// assert_eq!(sink.finish()?, 2);
/// # Ok::<(), cohort::CohortError>(())
/// ```
pub struct ParquetSink<W: Write> {
    file: String,
    columns: Vec<(String, CellKind)>,
    writer: BatchedWriter<W>,
    rows: usize,
}

impl<W: Write> ParquetSink<W> {
    /// Begins a table of `columns`, in their order, in `writer`. `file` names it in errors.
    ///
    /// # Errors
    /// If the columns are invalid.
    pub fn new(
        file: impl Into<String>,
        writer: W,
        columns: &[(&str, CellKind)],
    ) -> Result<Self, CohortError> {
        let file = file.into();
        let empty = columns.iter().map(|(name, kind)| {
            let dtype = match kind {
                CellKind::Integer => DataType::Int32,
                CellKind::Number => DataType::Float32,
                CellKind::Word => DataType::String,
            };
            Series::new_empty((*name).into(), &dtype).into_column()
        });
        let writer = DataFrame::new(0, empty.collect())
            .and_then(|frame| snappy(writer, frame.schema()))
            .map_err(|error| CohortError::not_written(&file, &error))?;
        let columns = columns.iter().map(|(name, kind)| ((*name).to_owned(), *kind)).collect();
        Ok(Self { file, columns, writer, rows: 0 })
    }

    /// Writes the next rows, as one row group; `cells` has a vector for each column.
    ///
    /// # Errors
    /// If there are too few or too many columns, if they are of another kind or of different
    /// lengths, or if the writer refuses.
    pub fn write(&mut self, cells: Vec<Cells>) -> Result<(), CohortError> {
        let rows = cells.first().map_or(0, Cells::len);
        if cells.len() != self.columns.len() {
            let reason = format!("{} columns, {} are needed", cells.len(), self.columns.len());
            return Err(CohortError::table(&self.file, reason));
        }
        for ((name, kind), cells) in self.columns.iter().zip(&cells) {
            if cells.kind() != *kind || cells.len() != rows {
                let reason = format!(
                    "column '{name}' has {} cells of kind {:?}, {rows} of kind {kind:?} are needed",
                    cells.len(),
                    cells.kind()
                );
                return Err(CohortError::table(&self.file, reason));
            }
        }
        let columns = self.columns.iter().zip(cells).map(|((name, _), c)| c.into_column(name));
        DataFrame::new(rows, columns.collect())
            .and_then(|frame| self.writer.write_batch(&frame))
            .map_err(|error| CohortError::not_written(&self.file, &error))?;
        self.rows += rows;
        Ok(())
    }

    /// Writes the end of the table, without which it cannot be read; returns the number of its
    /// rows.
    ///
    /// # Errors
    /// If the writer refuses.
    pub fn finish(self) -> Result<usize, CohortError> {
        self.writer.finish().map_err(|error| CohortError::not_written(&self.file, &error))?;
        Ok(self.rows)
    }
}

fn snappy<W: Write>(writer: W, schema: &Schema) -> PolarsResult<BatchedWriter<W>> {
    ParquetWriter::new(writer)
        .with_compression(ParquetCompression::Snappy)
        // Callers write several tables at once, one on each thread.
        .set_parallel(false)
        .batched(schema)
}

/// Writes parts as the row groups of a table, each made when it is written; nothing without a part.
pub(crate) fn write_parts<W: Write, T>(
    writer: W,
    parts: &[T],
    frame: impl Fn(&T) -> PolarsResult<DataFrame>,
) -> PolarsResult<()> {
    let Some(first) = parts.first() else { return Ok(()) };
    let mut writer = snappy(writer, frame(first)?.schema())?;
    for part in parts {
        writer.write_batch(&frame(part)?)?;
    }
    writer.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use polars::prelude::{ParquetReader, SerReader};
    use std::io::Cursor;

    const COLUMNS: [(&str, CellKind); 3] =
        [("step", CellKind::Integer), ("x", CellKind::Number), ("subset", CellKind::Word)];

    fn piece(first: i32) -> Vec<Cells> {
        vec![
            Cells::Integers((first..first + 3).collect()),
            Cells::Numbers(vec![Some(0.1 * first as f32), None, Some(f32::MIN_POSITIVE)]),
            Cells::Words(vec!["train", "test", "train"]),
        ]
    }

    fn written(pieces: &[Vec<Cells>]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut sink = ParquetSink::new("t", &mut bytes, &COLUMNS).expect("a table");
        for piece in pieces {
            sink.write(piece.clone()).expect("fits");
        }
        assert_eq!(sink.finish().expect("written"), 3 * pieces.len());
        bytes
    }

    #[test]
    fn pieces_read_back_in_order_and_exactly() {
        let bytes = written(&[piece(0), piece(7)]);
        assert_eq!(bytes, written(&[piece(0), piece(7)]), "the same bytes");
        let frame = ParquetReader::new(Cursor::new(bytes)).finish().expect("readable");
        let column = |name: &str| frame.column(name).expect("there").clone();
        let steps = column("step");
        let steps = steps.i32().expect("integers");
        let steps: Vec<_> = (0..6).map(|row| steps.get(row)).collect();
        assert_eq!(steps, [0, 1, 2, 7, 8, 9].map(Some));
        let numbers = column("x");
        let numbers = numbers.f32().expect("numbers");
        let numbers: Vec<_> = (0..6).map(|row| numbers.get(row)).collect();
        let least = Some(f32::MIN_POSITIVE);
        assert_eq!(numbers, [Some(0.0), None, least, Some(0.1 * 7.0), None, least]);
        let words = column("subset");
        let words = words.str().expect("words");
        let words: Vec<_> = (0..3).map(|row| words.get(row)).collect();
        assert_eq!(words, [Some("train"), Some("test"), Some("train")]);
    }

    #[test]
    fn a_table_without_rows_is_a_table() {
        let frame = ParquetReader::new(Cursor::new(written(&[]))).finish().expect("readable");
        assert_eq!((frame.height(), frame.width()), (0, 3));
    }

    #[test]
    fn pieces_that_do_not_fit_are_refused_by_column() {
        let mut sink = ParquetSink::new("t", Vec::new(), &COLUMNS).expect("a table");
        let mut short = piece(0);
        short[1] = Cells::Numbers(vec![None]);
        let mut other = piece(0);
        other[1] = Cells::Integers(vec![1, 2, 3]);
        for wrong in [short, other] {
            let error = sink.write(wrong).expect_err("does not fit").to_string();
            assert!(error.contains("'x'"), "{error}");
        }
        assert!(sink.write(piece(0)[..2].to_vec()).is_err(), "a column is missing");
        assert!(ParquetSink::new("t", Vec::new(), &[COLUMNS[0], COLUMNS[0]]).is_err());
    }
}
