//! Reader of the ZIP container in which PyTorch keeps a state dictionary.
//!
//! PyTorch stores its entries uncompressed. Only that is read here: the end record, the central
//! directory and the local headers, each length checked against the file and each entry against
//! its CRC-32, so that no byte of the file can lead to a panic or to silently wrong weights.

use crate::error::ModelError;

const END_OF_DIRECTORY: [u8; 4] = *b"PK\x05\x06";
const DIRECTORY_ENTRY: [u8; 4] = *b"PK\x01\x02";
const LOCAL_HEADER: [u8; 4] = *b"PK\x03\x04";
const END_LENGTH: usize = 22;
const LONGEST_COMMENT: usize = u16::MAX as usize;

/// The entries of a stored (uncompressed) ZIP file.
#[derive(Debug)]
pub(super) struct Archive<'a> {
    bytes: &'a [u8],
    entries: Vec<Entry>,
}

#[derive(Debug)]
struct Entry {
    name: String,
    header: usize,
    length: usize,
    crc: u32,
}

impl<'a> Archive<'a> {
    /// Reads the directory of `bytes`.
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, ModelError> {
        let end = find_end(bytes)?;
        let count = usize::from(u16_at(bytes, end + 10)?);
        let mut offset = size_at(bytes, end + 16)?;
        let mut entries = Vec::new();
        for _ in 0..count {
            if slice(bytes, offset, 4)? != DIRECTORY_ENTRY {
                return Err(broken(offset, "no directory entry where one is announced"));
            }
            if u16_at(bytes, offset + 10)? != 0 {
                return Err(broken(offset, "a compressed entry; PyTorch stores them as they are"));
            }
            let crc = u32_at(bytes, offset + 16)?;
            let length = size_at(bytes, offset + 24)?;
            let name_length = usize::from(u16_at(bytes, offset + 28)?);
            let extra = usize::from(u16_at(bytes, offset + 30)?);
            let comment = usize::from(u16_at(bytes, offset + 32)?);
            let header = size_at(bytes, offset + 42)?;
            let name = std::str::from_utf8(slice(bytes, offset + 46, name_length)?)
                .map_err(|_| broken(offset + 46, "an entry's name that is not UTF-8"))?
                .to_owned();
            entries.push(Entry { name, header, length, crc });
            offset += 46 + name_length + extra + comment;
        }
        Ok(Self { bytes, entries })
    }

    /// The name of the one entry whose name ends in `suffix`, without the suffix.
    pub(super) fn root_of(&self, suffix: &str) -> Result<&str, ModelError> {
        let mut roots = self.entries.iter().filter_map(|entry| entry.name.strip_suffix(suffix));
        match (roots.next(), roots.next()) {
            (Some(root), None) => Ok(root),
            (None, _) => Err(ModelError::MissingEntry(suffix.to_owned())),
            (Some(_), Some(_)) => Err(broken(0, "two state dictionaries in one file")),
        }
    }

    /// The checked content of the entry with this name, and where it starts in the file.
    pub(super) fn read(&self, name: &str) -> Result<(&'a [u8], usize), ModelError> {
        let entry = self.entries.iter().find(|entry| entry.name == name);
        let entry = entry.ok_or_else(|| ModelError::MissingEntry(name.to_owned()))?;
        let header = entry.header;
        if slice(self.bytes, header, 4)? != LOCAL_HEADER {
            return Err(broken(header, "no local header where the directory points"));
        }
        let name_length = usize::from(u16_at(self.bytes, header + 26)?);
        let extra = usize::from(u16_at(self.bytes, header + 28)?);
        let start = header + 30 + name_length + extra;
        let content = slice(self.bytes, start, entry.length)?;
        if crc32(content) != entry.crc {
            return Err(broken(start, "content that does not match its checksum"));
        }
        Ok((content, start))
    }
}

/// Offset of the end record, which is the last thing in the file but for a comment.
fn find_end(bytes: &[u8]) -> Result<usize, ModelError> {
    let last = bytes
        .len()
        .checked_sub(END_LENGTH)
        .ok_or_else(|| broken(bytes.len(), "a file too short for a ZIP archive"))?;
    (last.saturating_sub(LONGEST_COMMENT)..=last)
        .rev()
        .find(|&at| bytes[at..at + 4] == END_OF_DIRECTORY)
        .ok_or_else(|| broken(bytes.len(), "the end record of a ZIP archive is not there"))
}

fn slice(bytes: &[u8], offset: usize, length: usize) -> Result<&[u8], ModelError> {
    offset
        .checked_add(length)
        .and_then(|end| bytes.get(offset..end))
        .ok_or_else(|| broken(offset, "the file ends within an entry"))
}

fn u16_at(bytes: &[u8], offset: usize) -> Result<u16, ModelError> {
    let pair = slice(bytes, offset, 2)?;
    Ok(u16::from_le_bytes([pair[0], pair[1]]))
}

fn u32_at(bytes: &[u8], offset: usize) -> Result<u32, ModelError> {
    let four = slice(bytes, offset, 4)?;
    Ok(u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
}

/// A 32-bit size or offset; the value reserved for 64-bit archives is refused.
fn size_at(bytes: &[u8], offset: usize) -> Result<usize, ModelError> {
    match u32_at(bytes, offset)? {
        u32::MAX => {
            Err(broken(offset, "a 64-bit ZIP entry, which weights of this size never need"))
        }
        size => Ok(size as usize),
    }
}

fn broken(offset: usize, problem: &'static str) -> ModelError {
    ModelError::Archive { offset, problem }
}

/// CRC-32 as in ZIP (reflected polynomial 0xEDB88320).
pub(super) fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg());
        }
    }
    !crc
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_the_zip_format() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926); // the format's published check value
    }

    #[test]
    fn something_else_than_an_archive_is_refused() {
        let error = Archive::open(b"not an archive, but long enough").expect_err("no end record");
        assert!(error.to_string().contains("end record"), "{error}");
        let error = Archive::open(b"short").expect_err("5 bytes");
        assert!(error.to_string().contains("too short"), "{error}");
    }
}
