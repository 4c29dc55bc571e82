//! A look at the pages of a Parquet file before the table library decodes them: it reserves memory
//! for as many values as a damaged page claims, and no caller can catch that.

use std::fs::File;
use std::io::{Cursor, Read as _, Seek as _, SeekFrom};

use polars_buffer::Buffer;
use polars_parquet::parquet::metadata::{ColumnChunkMetadata, RowGroupMetadata};
use polars_parquet::parquet::page::CompressedPage;
use polars_parquet::parquet::read::{PageReader, read_metadata};

use crate::error::CohortError;
use crate::parquet_footer;
use crate::parquet_frame::{damaged, guarded};

/// Largest page, bytes; writers aim at one mebibyte.
const LARGEST_PAGE: usize = 256 << 20;

/// Most rows of a group, which is decoded as a whole; writers make groups of up to a few million.
const LARGEST_GROUP: usize = 1 << 25;

/// Checks that no page of the wanted columns claims more values than its group has rows, or more
/// bytes than fit into memory once it is unpacked, and no group more rows than fit.
///
/// # Errors
/// If the file is damaged.
pub(crate) fn check(file: &mut File, name: &str, wanted: &[String]) -> Result<(), CohortError> {
    guarded(name, || all_pages(file, wanted).ok_or_else(|| damaged(name)))
}

/// `None` if a page of the wanted columns, or a group, is damaged.
fn all_pages(file: &mut File, wanted: &[String]) -> Option<()> {
    let length = file.seek(SeekFrom::End(0)).ok()?;
    let metadata = read_metadata(file).ok()?;
    for group in &metadata.row_groups {
        if group.num_rows() > LARGEST_GROUP {
            return None;
        }
        let columns = group.parquet_columns().iter();
        let named = |column: &&ColumnChunkMetadata| {
            let root = column.descriptor().path_in_schema.first();
            root.is_some_and(|root| wanted.iter().any(|name| name == root.as_str()))
        };
        for column in columns.filter(named) {
            pages(file, length, group, column)?;
        }
    }
    Some(())
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
    let size_of_first = parquet_footer::page_size(&bytes);
    let reader = Cursor::new(Buffer::from(bytes));
    let mut values = 0;
    for (i, page) in PageReader::new(reader, column, Vec::new(), LARGEST_PAGE).enumerate() {
        match page.ok()? {
            CompressedPage::Data(page) => {
                let rest = group.num_rows().checked_sub(values)?;
                if page.num_values() > rest || page.uncompressed_size() > LARGEST_PAGE {
                    return None;
                }
                values += page.num_values();
            }
            // By the format a dictionary stands before the values.
            CompressedPage::Dict(_) => {
                if i > 0 || size_of_first? > LARGEST_PAGE as u64 {
                    return None;
                }
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use polars::prelude::{
        DataFrame, IntoColumn, NamedFrom, ParquetCompression, ParquetWriter, Series,
    };

    use super::*;

    /// A file of one column and one page.
    fn table() -> Vec<u8> {
        let cells: Vec<bool> = (0..1600).map(|i| i % 3 == 0).collect();
        let columns = vec![Series::new("x".into(), cells).into_column()];
        let mut frame = DataFrame::new(1600, columns).expect("a table");
        let mut bytes = Vec::new();
        ParquetWriter::new(&mut bytes)
            .with_compression(ParquetCompression::Uncompressed)
            .finish(&mut frame)
            .expect("writable");
        bytes
    }

    /// A number in Thrift's compact protocol.
    fn varint(mut number: u64) -> Vec<u8> {
        let mut bytes = Vec::new();
        while number > 0x7f {
            bytes.push((number & 0x7f) as u8 | 0x80);
            number >>= 7;
        }
        bytes.push(number as u8);
        bytes
    }

    /// The number at the start of some bytes, and how many of them it takes.
    fn number(bytes: &[u8]) -> (u64, usize) {
        let len = 1 + bytes.iter().position(|byte| byte & 0x80 == 0).expect("an end");
        let digits = bytes[..len].iter().rev();
        (digits.fold(0, |value, byte| (value << 7) | u64::from(byte & 0x7f)), len)
    }

    /// The file with another uncompressed size in the header of its page. The page loses as many
    /// bytes as the header gains, so that every other place and size stays true.
    fn claiming(bytes: &[u8], size: u64) -> Vec<u8> {
        let metadata = read_metadata(&mut Cursor::new(bytes)).expect("a footer");
        let range = metadata.row_groups[0].parquet_columns()[0].byte_range();
        assert_eq!(range.start, 4, "the page follows the mark");
        let end = usize::try_from(range.end).expect("a small file");
        // The fields of the header: the kind of page, the size, the size in the file.
        let (_, old) = number(&bytes[7..]);
        let stored_at = 7 + old + 1;
        let (stored, len) = number(&bytes[stored_at..]);
        let new = varint(2 * size);
        let more = new.len() - old;
        let stored = varint(stored - 2 * more as u64);
        assert_eq!(stored.len(), len, "the header grows by the size alone");
        [
            &bytes[..7],
            new.as_slice(),
            &bytes[7 + old..stored_at],
            stored.as_slice(),
            &bytes[stored_at + len..end - more],
            &bytes[end..],
        ]
        .concat()
    }

    #[test]
    fn a_page_that_claims_to_unpack_to_too_much_is_refused() {
        let bytes = table();
        let accepted = |bytes: &[u8]| {
            let mut file = tempfile::tempfile().expect("a temporary file");
            file.write_all(bytes).expect("writable");
            check(&mut file, "t.parquet", &["x".to_owned()]).is_ok()
        };
        assert!(accepted(&bytes));
        // Both need five bytes in the header.
        assert!(accepted(&claiming(&bytes, 1 << 27)));
        assert!(!accepted(&claiming(&bytes, LARGEST_PAGE as u64 + 1)));
    }
}
