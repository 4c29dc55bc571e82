//! The objects of a JSON file, one at a time: an array of objects, one object, or one object a line.
//!
//! A row in a message is the number of the object in its file, from 1; a column is its key.

use std::cell::Cell;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use serde::de::{Deserializer as _, SeqAccess, Visitor};
use serde_json::{Map, Value};

use crate::error::{CohortError, Place};

/// Longest object, bytes. A profile with its history has some 100 kB.
const LONGEST: usize = 16 << 20;

/// An object of a file.
pub(super) struct JsonRecord<'a> {
    pub(super) file: &'a str,
    pub(super) number: usize,
    pub(super) fields: Map<String, Value>,
    /// Columns of a sheet and their keys, for messages to name the column; nothing for a JSON file.
    pub(super) columns: &'static [(&'static str, &'static str)],
}

impl JsonRecord<'_> {
    /// The value at a key; `None` if it is absent or null.
    pub(super) fn value(&self, key: &str) -> Option<&Value> {
        self.fields.get(key).filter(|value| !value.is_null())
    }

    /// The text at a key without surrounding blanks; `None` if it is absent, null or empty.
    pub(super) fn text(&self, key: &str) -> Result<Option<&str>, CohortError> {
        match self.value(key) {
            None => Ok(None),
            Some(Value::String(text)) => Ok(Some(text.trim()).filter(|text| !text.is_empty())),
            Some(_) => Err(self.wrong(key, "a text")),
        }
    }

    /// The finite number at a key, also where it is written as text.
    pub(super) fn number(&self, key: &str) -> Result<Option<f64>, CohortError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let expected = "a number; write digits with a decimal point";
        number(value).map_err(|()| self.wrong(key, expected))
    }

    /// The key of this object, for messages.
    pub(super) fn place(&self, key: &str) -> Place {
        let first = key.split('.').next().unwrap_or(key);
        let column = self.columns.iter().find(|(_, of)| *of == first);
        Place::cell(self.file, self.number, column.map_or(key, |(column, _)| *column))
    }

    /// The error that says this value is not what was expected.
    pub(super) fn wrong(&self, key: &str, expected: &'static str) -> CohortError {
        match self.value(key) {
            None => CohortError::cell(self.place(key), "", expected),
            Some(Value::String(text)) => CohortError::cell(self.place(key), text, expected),
            Some(value) => wrong_part(self.place(key), value, expected),
        }
    }
}

/// The error that says a part of a value is not what was expected.
pub(super) fn wrong_part(place: Place, part: &Value, expected: &'static str) -> CohortError {
    CohortError::cell(place, &part.to_string(), expected)
}

/// A finite number, also written as text; `None` for null and an empty text.
pub(super) fn number(value: &Value) -> Result<Option<f64>, ()> {
    let number = match value {
        Value::Null => return Ok(None),
        Value::Number(number) => number.as_f64(),
        Value::String(text) if text.trim().is_empty() => return Ok(None),
        Value::String(text) => text.trim().parse().ok(),
        _ => None,
    };
    number.filter(|number| number.is_finite()).map(Some).ok_or(())
}

/// Calls `each` with every object of the file at `path`; messages call it `name`.
pub(super) fn for_each(
    path: &Path,
    name: &str,
    each: impl FnMut(JsonRecord<'_>) -> Result<(), CohortError>,
) -> Result<(), CohortError> {
    let failed = CohortError::io(name, "read");
    let file = std::fs::File::open(path).map_err(failed)?;
    let mut input = BufReader::with_capacity(1 << 16, file);
    let start = input.fill_buf().map_err(failed)?;
    if start.starts_with(b"\xFF\xFE") || start.starts_with(b"\xFE\xFF") {
        let reason = "UTF-16 text; save the file as UTF-8";
        return Err(CohortError::at(Place::row(name, 1), reason));
    }
    if start.starts_with(b"\xEF\xBB\xBF") {
        input.consume(3);
    }
    // The first character decides whether the objects are in an array.
    let first = loop {
        let buffer = input.fill_buf().map_err(failed)?;
        match buffer.first() {
            None => return Err(CohortError::empty(name)),
            Some(byte) if byte.is_ascii_whitespace() => input.consume(1),
            Some(byte) => break *byte,
        }
    };
    let used = Cell::new(0);
    let guarded = Guarded { inner: input, used: &used };
    let mut objects = Objects { name, used: &used, number: 0, each, refused: None };
    let read = match first {
        b'[' => {
            let mut json = serde_json::Deserializer::from_reader(guarded);
            json.deserialize_seq(&mut objects).and_then(|()| json.end())
        }
        b'{' => serde_json::Deserializer::from_reader(guarded)
            .into_iter::<Map<String, Value>>()
            .try_for_each(|object| objects.take::<serde_json::Error>(object?)),
        _ => {
            let reason = "not JSON: an array of objects is needed, like [{...}, {...}]";
            return Err(CohortError::table(name, reason));
        }
    };
    let Objects { number, refused, .. } = objects;
    if let Some(error) = refused {
        return Err(error);
    }
    read.map_err(|error| {
        let remedy = if error.is_eof() {
            "; the file is cut off"
        } else if error.to_string().contains("unicode") {
            "; save the file as UTF-8"
        } else {
            ""
        };
        CohortError::table(name, format!("record {}: {error}{remedy}", number + 1))
    })?;
    if number == 0 {
        return Err(CohortError::empty(name));
    }
    Ok(())
}

/// Visits the objects of an array.
struct Objects<'a, F> {
    name: &'a str,
    used: &'a Cell<usize>,
    number: usize,
    each: F,
    refused: Option<CohortError>,
}

impl<F: FnMut(JsonRecord<'_>) -> Result<(), CohortError>> Objects<'_, F> {
    /// Passes an object on. Where it is refused, its own error is kept and the reading ends.
    fn take<E: serde::de::Error>(&mut self, fields: Map<String, Value>) -> Result<(), E> {
        self.used.set(0);
        self.number += 1;
        let record = JsonRecord { file: self.name, number: self.number, fields, columns: &[] };
        (self.each)(record).map_err(|error| {
            self.refused = Some(error);
            E::custom("refused")
        })
    }
}

impl<'de, F> Visitor<'de> for &mut Objects<'_, F>
where
    F: FnMut(JsonRecord<'_>) -> Result<(), CohortError>,
{
    type Value = ();

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("an array of objects")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<(), A::Error> {
        while let Some(fields) = items.next_element()? {
            self.take::<A::Error>(fields)?;
        }
        Ok(())
    }
}

/// A reader that refuses an object longer than [`LONGEST`].
struct Guarded<'a, R> {
    inner: R,
    used: &'a Cell<usize>,
}

impl<R: Read> Read for Guarded<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.inner.read(buffer)?;
        self.used.set(self.used.get() + read);
        if self.used.get() > LONGEST {
            return Err(std::io::Error::other("an object longer than 16 MiB"));
        }
        Ok(read)
    }
}
