//! A look at the footer of a Parquet file before the table library parses it. The library reads a field that it knows
//! by its number, whatever type the file gives it, and skips lists entry by entry, as many as a damaged one claims.
//! So here fields must have the types of the format (apache/parquet-format, parquet.thrift), and lists no more
//! entries than bytes follow.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};

use crate::error::CohortError;

const MARK: [u8; 4] = *b"PAR1";
/// Structures and lists within each other; the format has seven.
const DEEPEST: usize = 16;

/// What a field or an entry holds.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Truth,
    Byte,
    Whole,
    Text,
    List(&'static Kind),
    Structure(Fields),
    /// Whatever the file says: the library skips it by that.
    Skipped,
}

/// Fields of a structure that the library reads: the first and the last number of those of a kind.
type Fields = &'static [(i16, i16, Kind)];

use Kind::{Byte, List, Skipped, Structure, Text, Truth, Whole};

const FILE: Fields = &[
    (1, 1, Whole),
    (2, 2, List(&Structure(SCHEMA_ELEMENT))),
    (3, 3, Whole),
    (4, 4, List(&Structure(ROW_GROUP))),
    (5, 5, List(&Structure(KEY_VALUE))),
    (6, 6, Text),
    (7, 7, List(&Structure(&[(1, 1, Structure(&[]))]))),
];
const KEY_VALUE: Fields = &[(1, 2, Text)];
const SCHEMA_ELEMENT: Fields =
    &[(1, 3, Whole), (4, 4, Text), (5, 9, Whole), (10, 10, Structure(LOGICAL_TYPE))];
const LOGICAL_TYPE: Fields = &[
    (1, 4, Structure(&[])),
    (5, 5, Structure(&[(1, 2, Whole)])),
    (6, 6, Structure(&[])),
    (7, 8, Structure(TIME)),
    (10, 10, Structure(&[(1, 1, Byte), (2, 2, Truth)])),
    (11, 15, Structure(&[])),
];
const TIME: Fields = &[(1, 1, Truth), (2, 2, Structure(&[(1, 3, Structure(&[]))]))];
const ROW_GROUP: Fields = &[
    (1, 1, List(&Structure(COLUMN_CHUNK))),
    (2, 3, Whole),
    (4, 4, List(&Structure(&[(1, 1, Whole), (2, 3, Truth)]))),
    (5, 7, Whole),
];
const COLUMN_CHUNK: Fields =
    &[(1, 1, Text), (2, 2, Whole), (3, 3, Structure(COLUMN)), (4, 7, Whole), (9, 9, Text)];
const COLUMN: Fields = &[
    (1, 1, Whole),
    (2, 2, List(&Whole)),
    (3, 3, List(&Text)),
    (4, 7, Whole),
    (8, 8, List(&Structure(KEY_VALUE))),
    (9, 11, Whole),
    (12, 12, Structure(STATISTICS)),
    (13, 13, List(&Structure(&[(1, 3, Whole)]))),
    (14, 15, Whole),
];
const STATISTICS: Fields = &[(1, 2, Text), (3, 4, Whole), (5, 6, Text), (7, 8, Truth)];

/// Checks that a file begins and ends as Parquet does, that the fields of its footer have the types of the format, and
/// that no list there claims more entries than bytes follow; messages call it `name`.
///
/// # Errors
/// If the file is damaged or cannot be read.
pub(crate) fn check(mut file: File, name: &str) -> Result<(), CohortError> {
    if is_whole(&mut file).map_err(CohortError::io(name, "read"))? {
        return Ok(());
    }
    let reason =
        "it does not begin and end as Parquet does, or its footer is damaged; it may be cut off";
    Err(CohortError::table(name, reason))
}

fn is_whole(file: &mut File) -> std::io::Result<bool> {
    let length = file.seek(SeekFrom::End(0))?;
    // Mark, footer, its length, mark.
    if length < 12 {
        return Ok(false);
    }
    let (mut first, mut last) = ([0; 4], [0; 8]);
    file.rewind()?;
    file.read_exact(&mut first)?;
    file.seek(SeekFrom::End(-8))?;
    file.read_exact(&mut last)?;
    let [a, b, c, d, mark @ ..] = last;
    let footer = u64::from(u32::from_le_bytes([a, b, c, d]));
    if first != MARK || mark != MARK || footer > length - 12 {
        return Ok(false);
    }
    file.seek(SeekFrom::Start(length - 8 - footer))?;
    let mut bytes = Vec::new();
    file.take(footer).read_to_end(&mut bytes)?;
    Ok(Thrift(&bytes).structure(FILE, DEEPEST).is_some())
}

/// The uncompressed size, bytes, that the header of a page at the start of `bytes` claims; `None`
/// if the header is damaged. The library keeps that of a dictionary to itself.
pub(crate) fn page_size(bytes: &[u8]) -> Option<u64> {
    const SIZE: i16 = 2;
    let mut thrift = Thrift(bytes);
    let (mut number, mut size) = (0, None);
    loop {
        let header = thrift.byte()?;
        if header & 0x0f == 0 {
            return size;
        }
        number = thrift.field(header, number)?;
        match (header & 0x0f, number) {
            // A truth value is in the header.
            (1 | 2, _) => (),
            (4..=6, SIZE) => {
                let zigzag = thrift.varint()?;
                // An odd one is negative.
                size = Some(if zigzag & 1 == 0 { zigzag >> 1 } else { return None });
            }
            (code, _) => thrift.value(code, Skipped, DEEPEST)?,
        }
    }
}

/// What is left of values in Thrift's compact protocol, in which footers are written.
struct Thrift<'a>(&'a [u8]);

impl Thrift<'_> {
    fn bytes(&mut self, count: usize) -> Option<()> {
        self.0 = self.0.get(count..)?;
        Some(())
    }

    fn byte(&mut self) -> Option<u8> {
        let byte = *self.0.first()?;
        self.bytes(1)?;
        Some(byte)
    }

    /// A whole number, seven bits a byte, the lowest first.
    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Some(value);
            }
        }
        None
    }

    /// The number of the field that a header begins, after that of the field before it.
    fn field(&mut self, header: u8, before: i16) -> Option<i16> {
        match header >> 4 {
            0 => {
                let zigzag = self.varint()?;
                let value = i16::try_from(zigzag >> 1).ok()?;
                Some(if zigzag & 1 == 0 { value } else { !value })
            }
            step => before.checked_add(i16::from(step)),
        }
    }

    /// Fields up to the one that ends a structure.
    fn structure(&mut self, known: Fields, deepest: usize) -> Option<()> {
        let mut number: i16 = 0;
        loop {
            let header = self.byte()?;
            if header & 0x0f == 0 {
                return Some(());
            }
            number = self.field(header, number)?;
            let kind = known.iter().find(|(first, last, _)| (*first..=*last).contains(&number));
            let kind = kind.map_or(Skipped, |(.., kind)| *kind);
            match (header & 0x0f, kind) {
                // A truth value is in the header.
                (1 | 2, Truth | Skipped) => (),
                (1 | 2, _) => return None,
                (code, kind) => self.value(code, kind, deepest)?,
            }
        }
    }

    fn value(&mut self, code: u8, kind: Kind, deepest: usize) -> Option<()> {
        match (code, kind) {
            (3, Byte | Skipped) => self.bytes(1),
            (4..=6, Whole | Skipped) => self.varint().map(|_| ()),
            (7, Skipped) => self.bytes(8),
            (8, Text | Skipped) => {
                let length = self.varint()?;
                self.bytes(usize::try_from(length).ok()?)
            }
            (9, List(_) | Skipped) => {
                let header = self.byte()?;
                let entries =
                    if header >> 4 == 15 { self.varint()? } else { u64::from(header >> 4) };
                if entries > self.0.len() as u64 {
                    return None;
                }
                let kind = if let List(of) = kind { *of } else { Skipped };
                (0..entries)
                    .try_for_each(|_| self.value(header & 0x0f, kind, deepest.checked_sub(1)?))
            }
            (12, Structure(_) | Skipped) => {
                let known = if let Structure(known) = kind { known } else { &[] };
                self.structure(known, deepest.checked_sub(1)?)
            }
            // Footers have no lists of truth values, sets or maps.
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the footer of a structure of these bytes is accepted.
    fn accepted(bytes: &[u8]) -> bool {
        Thrift(bytes).structure(&[], DEEPEST).is_some()
    }

    #[test]
    fn lists_have_no_more_entries_than_bytes_follow() {
        // Field 1, a list of two numbers; the end.
        assert!(accepted(&[0x19, 0x25, 1, 2, 0]));
        // The same list, which claims fifteen and more.
        assert!(!accepted(&[0x19, 0xf5, 0x0f, 1, 2, 0]));
        // Two billion truth values, which need no byte each to be skipped.
        assert!(!accepted(&[0x19, 0xf1, 0xff, 0xff, 0xff, 0xff, 0x07, 0]));
        assert!(!accepted(&[0x19, 0x21, 1, 1, 0]));
    }

    #[test]
    fn the_size_of_a_page_is_in_its_header() {
        // A dictionary of 300 bytes, 10 of them in the file, with six plain values.
        let header = [0x15, 4, 0x15, 0xd8, 4, 0x15, 20, 0x4c, 0x15, 12, 0x15, 0, 0, 0];
        assert_eq!(page_size(&header), Some(300));
        for cut in 0..header.len() {
            assert_eq!(page_size(&header[..cut]), None, "{cut}");
        }
        // No size; a size below zero.
        assert_eq!(page_size(&[0x15, 4, 0]), None);
        assert_eq!(page_size(&[0x15, 4, 0x15, 3, 0]), None);
    }

    #[test]
    fn fields_of_every_kind_are_passed_and_none_is_cut_off() {
        // A truth value, a byte, a number of two bytes, a double, a text, a structure with a field of its own number.
        let whole = [
            0x11, 0x13, 9, 0x15, 0x80, 1, 0x17, 0, 0, 0, 0, 0, 0, 0, 0, 0x18, 2, b'a', b'b', 0x1c,
            0x05, 8, 1, 0, 0,
        ];
        assert!(accepted(&whole));
        for cut in 0..whole.len() {
            assert!(!accepted(&whole[..cut]), "{cut}");
        }
        // A map; structures without end.
        assert!(!accepted(&[0x1b, 0, 0]));
        assert!(!accepted(&[0x1c; 40]));
    }

    #[test]
    fn known_fields_have_the_types_of_the_format() {
        // Rows, a number; the same as a text, and as a truth value.
        assert!(Thrift(&[0x36, 7, 0]).structure(FILE, DEEPEST).is_some());
        assert!(Thrift(&[0x38, 0, 0]).structure(FILE, DEEPEST).is_none());
        assert!(Thrift(&[0x31, 0]).structure(FILE, DEEPEST).is_none());
        // The schema as a number that would be read as a list of sixteen million entries.
        assert!(
            Thrift(&[0x26, 0xfc, 0xff, 0xff, 0xff, 0x07, 0]).structure(FILE, DEEPEST).is_none()
        );
        // Numbers beyond those that the library keeps: one that it would cut to 3, and one step past the largest.
        let beyond = [0x05, 0x86, 0x80, 0x08, 7, 0];
        assert!(Thrift(&beyond).structure(FILE, DEEPEST).is_none());
        let past_the_largest = [0x05, 0xfe, 0xff, 0x03, 7, 0x15, 7, 0];
        assert!(Thrift(&past_the_largest).structure(FILE, DEEPEST).is_none());
        // A field that is unknown, by its own number.
        assert!(Thrift(&[0x08, 0xc8, 1, 1, b'x', 0]).structure(FILE, DEEPEST).is_some());
    }
}
