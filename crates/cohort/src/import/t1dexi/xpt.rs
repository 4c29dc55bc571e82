//! SAS transport files (XPORT) of version 5, row by row.
//!
//! The layout is SAS technical note TS-140: records of 80 bytes; headers for library, member,
//! variables (`NAMESTR`) and observations; numbers as IBM hexadecimal floating point; the last
//! record is filled with blanks. Memory holds one row.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use crate::error::{CohortError, Place};
use crate::import::files::name as file_name;

/// Bytes of a record.
const RECORD: usize = 80;
/// Most variables of a member; SAS allows 32,767.
const VARIABLES: usize = 32_767;
/// IBM numbers below this are the smallest one, by which the study's files mean 0.
const TINY: f64 = 1e-60;

/// A variable of a file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Variable {
    name: String,
    numeric: bool,
    start: usize,
    len: usize,
}

impl Variable {
    /// Whether the file has it.
    pub(super) const fn exists(&self) -> bool {
        self.len > 0
    }
}

/// An open file, before its first row.
pub(super) struct Xpt {
    file: String,
    input: BufReader<File>,
    variables: Vec<Variable>,
    row_len: usize,
    rows: u64,
    /// Rows at the end that blanks of the last record could be.
    doubtful: u64,
}

/// A row and its number, from 1.
pub(super) struct XptRow<'a> {
    file: &'a str,
    number: u64,
    bytes: &'a [u8],
}

impl Xpt {
    /// Opens the file at `path` and reads its headers.
    pub(super) fn open(path: &Path) -> Result<Self, CohortError> {
        let name = &file_name(path);
        let failed = CohortError::io(name, "read");
        let file = File::open(path).map_err(failed)?;
        let size = file.metadata().map_err(failed)?.len();
        if size == 0 {
            return Err(CohortError::empty(name));
        }
        let mut headers =
            Headers { file: name, input: BufReader::with_capacity(1 << 20, file), at: 0 };
        let library = headers.bytes(RECORD)?;
        if library.starts_with(b"HEADER RECORD*******LIBV8") {
            return Err(headers.wrong("a transport file of version 8; write version 5"));
        }
        if !library.starts_with(b"HEADER RECORD*******LIBRARY") {
            return Err(headers.wrong("not a SAS transport file of version 5"));
        }
        headers.bytes(2 * RECORD)?;
        let member = headers.expect(b"HEADER RECORD*******MEMBER", "the header of a member")?;
        let size_of = match &member[74..78] {
            b"0136" => 136,
            _ => 140,
        };
        headers.expect(b"HEADER RECORD*******DSCRPTR", "the member's descriptor")?;
        headers.bytes(2 * RECORD)?;
        let names = headers.expect(b"HEADER RECORD*******NAMESTR", "the header of variables")?;
        let count = std::str::from_utf8(&names[54..58])
            .ok()
            .and_then(|text| text.trim().parse::<usize>().ok())
            .filter(|count| (1..=VARIABLES).contains(count))
            .ok_or_else(|| headers.wrong("the number of variables is not a number"))?;
        let described = headers.bytes((count * size_of).next_multiple_of(RECORD))?;
        let variables = described.chunks_exact(size_of).take(count).map(variable);
        let variables: Option<Vec<Variable>> = variables.collect();
        let variables = variables.ok_or_else(|| headers.wrong("a variable is broken"))?;
        headers.expect(b"HEADER RECORD*******OBS", "the header of observations")?;
        let row_len = variables.iter().map(|one| one.start + one.len).max().unwrap_or(0);
        let data = size.saturating_sub(headers.at);
        if row_len == 0 || !size.is_multiple_of(RECORD as u64) {
            return Err(headers.wrong("the file is cut off: its size is no multiple of 80 bytes"));
        }
        let rows = data / row_len as u64;
        if rows == 0 {
            return Err(CohortError::empty(name));
        }
        let left = data % row_len as u64;
        let doubtful = (RECORD as u64 - 1).saturating_sub(left) / row_len as u64;
        let input = headers.input;
        Ok(Self { file: name.into(), input, variables, row_len, rows, doubtful })
    }

    /// The first variable of some names.
    pub(super) fn variable(&self, names: &[&str]) -> Result<Variable, CohortError> {
        let of_name = |name: &&str| self.variables.iter().find(|one| one.name == *name);
        names.iter().find_map(of_name).cloned().ok_or_else(|| {
            let found: Vec<&str> = self.variables.iter().map(|one| one.name.as_str()).collect();
            CohortError::missing_column(&self.file, names[0], &found)
        })
    }

    /// The same; a variable without values if there is none.
    pub(super) fn optional(&self, names: &[&str]) -> Variable {
        self.variable(names).unwrap_or_default()
    }

    /// Calls `each` with every row.
    pub(super) fn for_each(
        mut self,
        mut each: impl FnMut(XptRow<'_>) -> Result<(), CohortError>,
    ) -> Result<(), CohortError> {
        let mut bytes = vec![0; self.row_len];
        for number in 1..=self.rows {
            self.input.read_exact(&mut bytes).map_err(CohortError::io(&self.file, "read"))?;
            let filling = number + self.doubtful > self.rows && bytes.iter().all(|b| *b == b' ');
            if filling {
                break;
            }
            if bytes.starts_with(b"HEADER RECORD*******MEMBER") {
                let reason = "a second member; write one table a file";
                return Err(CohortError::table(&self.file, reason));
            }
            each(XptRow { file: &self.file, number, bytes: &bytes })?;
        }
        Ok(())
    }
}

impl XptRow<'_> {
    /// The cell of a variable, for messages.
    pub(super) fn place(&self, variable: &Variable) -> Place {
        let row = usize::try_from(self.number).unwrap_or(usize::MAX);
        Place::cell(self.file, row, &variable.name)
    }

    /// The text of a variable without blanks around it; empty for a number.
    pub(super) fn text(&self, variable: &Variable) -> Cow<'_, str> {
        if variable.numeric {
            return Cow::Borrowed("");
        }
        // Free text of a study may be in an older encoding; the words read here are ASCII.
        String::from_utf8_lossy(self.cell(variable).trim_ascii())
    }

    /// The number of a variable, also where it is text; `None` if it is missing.
    pub(super) fn number(&self, variable: &Variable) -> Result<Option<f64>, CohortError> {
        if variable.numeric {
            return Ok(ibm(self.cell(variable)));
        }
        let text = self.text(variable);
        if text.is_empty() || text == "." {
            return Ok(None);
        }
        match text.parse::<f64>() {
            Ok(value) if value.is_nan() => Ok(None),
            Ok(value) if value.abs() < TINY => Ok(Some(0.0)),
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(self.wrong(variable, "a number; write digits with a decimal point")),
        }
    }

    /// The error that says this cell is not what was expected.
    pub(super) fn wrong(&self, variable: &Variable, expected: &'static str) -> CohortError {
        let place = self.place(variable);
        if !variable.numeric {
            return CohortError::cell(place, &self.text(variable), expected);
        }
        let value = ibm(self.cell(variable)).map(|value| value.to_string()).unwrap_or_default();
        CohortError::Cell { place, value, expected }
    }

    fn cell(&self, variable: &Variable) -> &[u8] {
        &self.bytes[variable.start..variable.start + variable.len]
    }
}

/// The headers of a file while they are read.
struct Headers<'a> {
    file: &'a str,
    input: BufReader<File>,
    at: u64,
}

impl Headers<'_> {
    fn bytes(&mut self, len: usize) -> Result<Vec<u8>, CohortError> {
        let mut bytes = vec![0; len];
        self.input.read_exact(&mut bytes).map_err(|source| match source.kind() {
            std::io::ErrorKind::UnexpectedEof => self.wrong("the file is cut off in its headers"),
            _ => CohortError::io(self.file, "read")(source),
        })?;
        self.at += len as u64;
        Ok(bytes)
    }

    fn expect(&mut self, start: &[u8], what: &str) -> Result<Vec<u8>, CohortError> {
        let record = self.bytes(RECORD)?;
        if record.starts_with(start) {
            return Ok(record);
        }
        Err(self.wrong(&format!("{what} is not at byte {}", self.at - RECORD as u64)))
    }

    fn wrong(&self, reason: &str) -> CohortError {
        CohortError::table(self.file, reason)
    }
}

/// A variable from its description; `None` if it is broken.
fn variable(described: &[u8]) -> Option<Variable> {
    let short = |at: usize| Some(i16::from_be_bytes(described.get(at..at + 2)?.try_into().ok()?));
    let start = i32::from_be_bytes(described.get(84..88)?.try_into().ok()?);
    let numeric = match short(0)? {
        1 => true,
        2 => false,
        _ => return None,
    };
    let len = usize::try_from(short(4)?).ok()?;
    if len == 0 || numeric && len > 8 {
        return None;
    }
    let name = std::str::from_utf8(described.get(8..16)?).ok()?.trim().to_ascii_uppercase();
    // The longest row of all variables at their longest.
    let start = usize::try_from(start).ok().filter(|start| *start <= 1 << 30)?;
    Some(Variable { name, numeric, start, len })
}

/// An IBM hexadecimal number of 2 to 8 bytes; `None` if it is one of SAS's missing values.
fn ibm(bytes: &[u8]) -> Option<f64> {
    let mut all = [0; 8];
    all[..bytes.len()].copy_from_slice(bytes);
    let missing = matches!(all[0], b'.' | b'_' | b'A'..=b'Z');
    if missing && all[1..].iter().all(|byte| *byte == 0) {
        return None;
    }
    let bits = u64::from_be_bytes(all);
    let fraction = (bits & 0x00FF_FFFF_FFFF_FFFF) as f64;
    // 14 hexadecimal digits follow the point; the exponent is biased by 64.
    let exponent = ((bits >> 56) & 0x7F) as i32 - 64 - 14;
    let value = fraction * 16_f64.powi(exponent);
    let value = if value < TINY { 0.0 } else { value };
    Some(if bits >> 63 == 1 { -value } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_technical_note() {
        // TS-140 prints 1, -1, 0 and missing; 100 is 6.25 x 16.
        for (bytes, value) in [
            ([0x41, 0x10, 0, 0, 0, 0, 0, 0], Some(1.0)),
            ([0xC1, 0x10, 0, 0, 0, 0, 0, 0], Some(-1.0)),
            ([0x42, 0x64, 0, 0, 0, 0, 0, 0], Some(100.0)),
            ([0; 8], Some(0.0)),
            ([0x00, 0x10, 0, 0, 0, 0, 0, 0], Some(0.0)),
            ([0x2E, 0, 0, 0, 0, 0, 0, 0], None),
            ([0x41, 0, 0, 0, 0, 0, 0, 0], None),
        ] {
            assert_eq!(ibm(&bytes), value, "{bytes:x?}");
        }
        // Shorter numbers leave out the last digits.
        assert_eq!(ibm(&[0x42, 0x64, 0x80]), Some(100.5));
    }
}
