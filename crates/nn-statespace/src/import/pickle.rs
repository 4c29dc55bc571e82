//! A strict reader of the pickles that PyTorch and scikit-learn write for flat dictionaries.
//!
//! Nothing is executed: a reference to a Python class or function stays a name, a call stays a
//! record of the call. Only the opcodes that such files use are known; anything else is an error
//! with its offset. Depth and length are bounded by the file, so that no input can exhaust the
//! stack or the memory.

use std::rc::Rc;

use crate::error::ModelError;

/// Deeper nesting than any of the files has (theirs is 6).
const DEEPEST: u8 = 24;
/// Larger than any of the pickles (theirs are below 5 kB).
const LONGEST: usize = 1 << 20;

/// A Python value, as far as these files need it.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    Text(Rc<str>),
    Bytes(Rc<[u8]>),
    Tuple(Rc<Vec<Value>>),
    Dict(Vec<(Value, Value)>),
    /// A class or function by name.
    Global {
        module: Rc<str>,
        name: Rc<str>,
    },
    /// `callable(*arguments)`, not called.
    Call(Rc<(Value, Value)>),
    /// An object with the state that `__setstate__` would get.
    Built(Rc<(Value, Value)>),
    /// A reference to something outside the pickle (a tensor's storage).
    Persistent(Rc<Value>),
}

impl Value {
    pub(super) fn is_global(&self, of_module: &[&str], of_name: &str) -> bool {
        matches!(self, Self::Global { module, name }
            if **name == *of_name && of_module.contains(&&**module))
    }

    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    pub(super) fn size(&self) -> Option<usize> {
        match self {
            Self::Int(value) => usize::try_from(*value).ok(),
            _ => None,
        }
    }

    pub(super) fn tuple(&self) -> Option<&[Value]> {
        match self {
            Self::Tuple(items) => Some(items),
            _ => None,
        }
    }

    /// The value under a text key.
    pub(super) fn entry(&self, key: &str) -> Option<&Value> {
        match self {
            Self::Dict(items) => items.iter().find(|(k, _)| k.text() == Some(key)).map(|(_, v)| v),
            _ => None,
        }
    }
}

/// What lies on the machine's stack: a value with its depth of nesting, or a mark.
#[derive(Clone)]
enum Slot {
    Mark,
    Value(Value, u8),
}

/// Reads one pickle; `base` is where it starts in its file, for messages.
pub(super) fn read(bytes: &[u8], base: usize) -> Result<Value, ModelError> {
    if bytes.len() > LONGEST {
        return Err(ModelError::Pickle {
            offset: base,
            opcode: 0,
            problem: "longer than any file of this kind",
        });
    }
    let mut machine =
        Machine { bytes, base, at: 0, start: 0, opcode: 0, stack: vec![], memo: vec![] };
    loop {
        if let Some(value) = machine.execute_next()? {
            return Ok(value);
        }
    }
}

struct Machine<'a> {
    bytes: &'a [u8],
    base: usize,
    at: usize,
    /// Where the present opcode stands, and what it is.
    start: usize,
    opcode: u8,
    stack: Vec<Slot>,
    memo: Vec<Option<(Value, u8)>>,
}

impl Machine<'_> {
    fn execute_next(&mut self) -> Result<Option<Value>, ModelError> {
        self.start = self.at;
        self.opcode = 0;
        self.opcode = self.take(1)?[0];
        match self.opcode {
            0x80 => match self.take(1)?[0] {
                2..=5 => {}
                _ => return Err(self.broken("a protocol other than 2 to 5")),
            },
            0x95 => drop(self.take(8)?), // FRAME: a hint for buffering
            b'.' => {
                let value = self.pop()?.0;
                if !self.stack.is_empty() {
                    return Err(self.broken("values left over at the end"));
                }
                return Ok(Some(value));
            }
            b'(' => self.stack.push(Slot::Mark),
            b'N' => self.push(Value::None),
            0x88 => self.push(Value::Bool(true)),
            0x89 => self.push(Value::Bool(false)),
            b'K' => {
                let value = i64::from(self.take(1)?[0]);
                self.push(Value::Int(value));
            }
            b'M' => {
                let value = i64::from(u16::from_le_bytes(self.array()?));
                self.push(Value::Int(value));
            }
            b'J' => {
                let value = i64::from(i32::from_le_bytes(self.array()?));
                self.push(Value::Int(value));
            }
            b'G' => {
                let value = f64::from_be_bytes(self.array()?);
                self.push(Value::Float(value));
            }
            0x8c => {
                let length = usize::from(self.take(1)?[0]);
                self.push_text(length)?;
            }
            b'X' => {
                let length = u32::from_le_bytes(self.array()?) as usize;
                self.push_text(length)?;
            }
            b'C' => {
                let length = usize::from(self.take(1)?[0]);
                self.push_bytes(length)?;
            }
            b'B' => {
                let length = u32::from_le_bytes(self.array()?) as usize;
                self.push_bytes(length)?;
            }
            b'}' => self.push(Value::Dict(vec![])),
            b')' => self.push(Value::Tuple(Rc::new(vec![]))),
            0x85 => self.tuple_of(1)?,
            0x86 => self.tuple_of(2)?,
            0x87 => self.tuple_of(3)?,
            b't' => {
                let (items, depth) = self.pop_to_mark()?;
                self.nest(Value::Tuple(Rc::new(items)), depth)?;
            }
            b's' => {
                let (value, deep_value) = self.pop()?;
                let (key, deep_key) = self.pop()?;
                self.set_items(vec![key, value], deep_value.max(deep_key))?;
            }
            b'u' => {
                let (items, depth) = self.pop_to_mark()?;
                self.set_items(items, depth)?;
            }
            b'c' => {
                let module = self.line()?;
                let name = self.line()?;
                self.push(Value::Global { module, name });
            }
            0x93 => match (self.pop()?.0, self.pop()?.0) {
                (Value::Text(name), Value::Text(module)) => {
                    self.push(Value::Global { module, name });
                }
                _ => return Err(self.broken("a name that is not text")),
            },
            b'R' | 0x81 => {
                let (arguments, deep_arguments) = self.pop()?;
                let (callable, deep_callable) = self.pop()?;
                if callable.is_global(&["collections"], "OrderedDict") {
                    self.push(Value::Dict(vec![]));
                } else {
                    let depth = deep_arguments.max(deep_callable);
                    self.nest(Value::Call(Rc::new((callable, arguments))), depth)?;
                }
            }
            b'b' => {
                let (state, deep_state) = self.pop()?;
                let (object, deep_object) = self.pop()?;
                let depth = deep_state.max(deep_object);
                self.nest(Value::Built(Rc::new((object, state))), depth)?;
            }
            b'Q' => {
                let (value, depth) = self.pop()?;
                self.nest(Value::Persistent(Rc::new(value)), depth)?;
            }
            b'q' => {
                let index = usize::from(self.take(1)?[0]);
                self.remember(index)?;
            }
            b'r' => {
                let index = u32::from_le_bytes(self.array()?) as usize;
                self.remember(index)?;
            }
            0x94 => self.remember(self.memo.len())?,
            b'h' => {
                let index = usize::from(self.take(1)?[0]);
                self.recall(index)?;
            }
            b'j' => {
                let index = u32::from_le_bytes(self.array()?) as usize;
                self.recall(index)?;
            }
            _ => return Err(self.broken("an opcode that flat dictionaries of arrays do not use")),
        }
        Ok(None)
    }

    fn broken(&self, problem: &'static str) -> ModelError {
        ModelError::Pickle { offset: self.base + self.start, opcode: self.opcode, problem }
    }

    fn take(&mut self, length: usize) -> Result<&[u8], ModelError> {
        let end = self.at.checked_add(length).filter(|end| *end <= self.bytes.len());
        let Some(end) = end else {
            return Err(self.broken("the pickle ends early"));
        };
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], ModelError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    fn line(&mut self) -> Result<Rc<str>, ModelError> {
        let Some(length) = self.bytes[self.at..].iter().position(|byte| *byte == b'\n') else {
            return Err(self.broken("a name without an end"));
        };
        let text: Option<Rc<str>> = std::str::from_utf8(self.take(length)?).ok().map(Rc::from);
        self.take(1)?;
        text.ok_or_else(|| self.broken("a name that is not UTF-8"))
    }

    fn push(&mut self, value: Value) {
        self.stack.push(Slot::Value(value, 0));
    }

    fn push_text(&mut self, length: usize) -> Result<(), ModelError> {
        let text: Option<Rc<str>> = std::str::from_utf8(self.take(length)?).ok().map(Rc::from);
        let text = text.ok_or_else(|| self.broken("text that is not UTF-8"))?;
        self.push(Value::Text(text));
        Ok(())
    }

    fn push_bytes(&mut self, length: usize) -> Result<(), ModelError> {
        let bytes: Rc<[u8]> = Rc::from(self.take(length)?);
        self.push(Value::Bytes(bytes));
        Ok(())
    }

    /// Pushes a value that holds others, the deepest of which has `depth`.
    fn nest(&mut self, value: Value, depth: u8) -> Result<(), ModelError> {
        if depth >= DEEPEST {
            return Err(self.broken("nested deeper than any file of this kind"));
        }
        self.stack.push(Slot::Value(value, depth + 1));
        Ok(())
    }

    fn pop(&mut self) -> Result<(Value, u8), ModelError> {
        match self.stack.pop() {
            Some(Slot::Value(value, depth)) => Ok((value, depth)),
            Some(Slot::Mark) => Err(self.broken("a mark where a value should be")),
            None => Err(self.broken("nothing to work on")),
        }
    }

    fn pop_to_mark(&mut self) -> Result<(Vec<Value>, u8), ModelError> {
        let mark = self.stack.iter().rposition(|slot| matches!(slot, Slot::Mark));
        let Some(mark) = mark else {
            return Err(self.broken("no mark"));
        };
        let mut deepest = 0;
        let mut items = Vec::with_capacity(self.stack.len() - mark);
        for slot in self.stack.drain(mark..) {
            if let Slot::Value(value, depth) = slot {
                deepest = deepest.max(depth);
                items.push(value);
            }
        }
        Ok((items, deepest))
    }

    fn tuple_of(&mut self, count: usize) -> Result<(), ModelError> {
        let mut deepest = 0;
        let mut items = Vec::with_capacity(count);
        for _ in 0..count {
            let (value, depth) = self.pop()?;
            deepest = deepest.max(depth);
            items.push(value);
        }
        items.reverse();
        self.nest(Value::Tuple(Rc::new(items)), deepest)
    }

    fn set_items(&mut self, items: Vec<Value>, depth: u8) -> Result<(), ModelError> {
        let (value, own) = self.pop()?;
        let Value::Dict(mut entries) = value else {
            return Err(self.broken("items for something that is not a dictionary"));
        };
        let mut items = items.into_iter();
        while let Some(key) = items.next() {
            let Some(value) = items.next() else {
                return Err(self.broken("a key without a value"));
            };
            entries.push((key, value));
        }
        // nest adds one level; a dictionary that already has it keeps it.
        self.nest(Value::Dict(entries), depth.max(own.saturating_sub(1)))
    }

    fn remember(&mut self, index: usize) -> Result<(), ModelError> {
        let Some(Slot::Value(value, depth)) = self.stack.last() else {
            return Err(self.broken("nothing to remember"));
        };
        // A dictionary is remembered while still empty and filled afterwards; a later reference
        // to it would not see its items, so that it is refused there.
        let kept = (!matches!(value, Value::Dict(_))).then(|| (value.clone(), *depth));
        if index > self.memo.len() {
            return Err(self.broken("a memory place out of order"));
        }
        if index == self.memo.len() {
            self.memo.push(kept);
        } else {
            self.memo[index] = kept;
        }
        Ok(())
    }

    fn recall(&mut self, index: usize) -> Result<(), ModelError> {
        match self.memo.get(index) {
            Some(Some((value, depth))) => {
                self.stack.push(Slot::Value(value.clone(), *depth));
                Ok(())
            }
            Some(None) => Err(self.broken("a second reference to a dictionary")),
            None => Err(self.broken("a memory place that was never filled")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_dictionary_is_read() {
        // pickle.dumps({"a": (1, 2.5)}, protocol=2) of CPython, byte for byte
        let bytes =
            b"\x80\x02}q\x00X\x01\x00\x00\x00aq\x01K\x01G@\x04\x00\x00\x00\x00\x00\x00\x86q\x02s.";
        let value = read(bytes, 0).expect("valid");
        let tuple = value.entry("a").and_then(Value::tuple).expect("a tuple under a");
        assert_eq!(tuple, [Value::Int(1), Value::Float(2.5)]);
    }

    #[test]
    fn an_unknown_opcode_is_named_with_its_offset() {
        let error = read(b"\x80\x02}q\x00i.", 100).expect_err("INST is not read");
        assert_eq!(
            error.to_string(),
            "pickle, offset 105, opcode 0x69: an opcode that flat dictionaries of arrays do not \
             use; is this the file that the authors published?"
        );
    }

    #[test]
    fn deep_nesting_is_refused_before_it_can_exhaust_the_stack() {
        let mut bytes = b"\x80\x02)".to_vec();
        bytes.extend(std::iter::repeat_n(0x85, 100_000));
        bytes.push(b'.');
        let error = read(&bytes, 0).expect_err("100,000 levels");
        assert!(error.to_string().contains("nested deeper"), "{error}");
    }

    #[test]
    fn growth_by_doubling_references_stays_small() {
        // t = (t, t), again and again: 2^n leaves if it were copied
        let mut bytes = b"\x80\x02)".to_vec();
        for _ in 0..20 {
            bytes.extend(b"q\x00h\x00\x86");
        }
        bytes.push(b'.');
        assert!(matches!(read(&bytes, 0), Ok(Value::Tuple(_))));
    }
}
