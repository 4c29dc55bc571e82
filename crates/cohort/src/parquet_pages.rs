//! A look at the pages of a Parquet file before the table library decodes them: it reserves memory
//! for as many values as a damaged page claims, and no caller can catch that.

use std::fs::File;
use std::io::{Cursor, Read as _, Seek as _, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};

use polars_buffer::Buffer;
use polars_parquet::parquet::metadata::{ColumnChunkMetadata, RowGroupMetadata};
use polars_parquet::parquet::page::CompressedPage;
use polars_parquet::parquet::read::{PageReader, read_metadata};

use crate::error::CohortError;

/// Largest page, bytes; writers aim at one mebibyte.
const LARGEST_PAGE: usize = 256 << 20;

/// Most rows of a group, which is decoded as a whole; writers make groups of up to a few million.
const LARGEST_GROUP: usize = 1 << 25;

/// Checks that no page of the wanted columns claims more values than its group has rows, and no group
/// more rows than fit into memory.
///
/// # Errors
/// [`CohortError::Table`] for a damaged file.
pub(crate) fn check(
    file: &mut File,
    name: &str,
    wanted: impl Fn(&str) -> bool,
) -> Result<(), CohortError> {
    let damaged = || CohortError::Table {
        file: name.into(),
        reason: "damaged, or of a kind that cannot be read".into(),
    };
    // The library panics on some damage.
    let looked = catch_unwind(AssertUnwindSafe(|| {
        let length = file.seek(SeekFrom::End(0)).ok()?;
        let metadata = read_metadata(file).ok()?;
        for group in &metadata.row_groups {
            if group.num_rows() > LARGEST_GROUP {
                return None;
            }
            let columns = group.parquet_columns().iter();
            let named = |column: &&ColumnChunkMetadata| {
                column.descriptor().path_in_schema.first().is_some_and(|root| wanted(root))
            };
            for column in columns.filter(named) {
                pages(file, length, group, column)?;
            }
        }
        Some(())
    }));
    looked.ok().flatten().ok_or_else(damaged)
}

/// `None` if a page of the column is damaged.
fn pages(
    file: &mut File,
    length: u64,
    group: &RowGroupMetadata,
    column: &ColumnChunkMetadata,
) -> Option<()> {
    let range = column.byte_range();
    if range.start > range.end || range.end > length {
        return None;
    }
    file.seek(SeekFrom::Start(range.start)).ok()?;
    let mut bytes = vec![0; usize::try_from(range.end - range.start).ok()?];
    file.read_exact(&mut bytes).ok()?;
    let reader = Cursor::new(Buffer::from(bytes));
    let mut values = 0;
    for page in PageReader::new(reader, column, Vec::new(), LARGEST_PAGE) {
        if let CompressedPage::Data(page) = page.ok()? {
            let rest = group.num_rows().checked_sub(values)?;
            if page.num_values() > rest {
                return None;
            }
            values += page.num_values();
        }
    }
    Some(())
}
