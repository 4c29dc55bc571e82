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

    /// The arguments, if this is a call of a function of that name in one of these modules.
    pub(super) fn call(&self, of_module: &[&str], of_name: &str) -> Option<&Value> {
        match self {
            Self::Call(call) if call.0.is_global(of_module, of_name) => Some(&call.1),
            _ => None,
        }
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

/// What lies on the machine's stack: a value with its depth of nesting, or `None` for a mark.
type Slot = Option<(Value, u8)>;

/// Reads one pickle; `base` is where it starts in its file, for messages.
pub(super) fn read(bytes: &[u8], base: usize) -> Result<Value, ModelError> {
    let mut machine =
        Machine { bytes, base, at: 0, start: 0, opcode: 0, stack: vec![], memo: vec![] };
    if bytes.len() > LONGEST {
        return Err(machine.broken("longer than any file of this kind"));
    }
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
    /// `None` for a dictionary.
    memo: Vec<Option<(Value, u8)>>,
}

impl Machine<'_> {
    /// Does the next opcode; returns the value at the end.
    fn execute_next(&mut self) -> Result<Option<Value>, ModelError> {
        self.start = self.at;
        self.opcode = 0;
        self.opcode = self.take(1)?[0];
        // Values that hold no others are pushed below.
        let value = match self.opcode {
            b'.' => {
                let value = self.pop()?.0;
                if !self.stack.is_empty() {
                    return Err(self.broken("values left over at the end"));
                }
                return Ok(Some(value));
            }
            b'N' => Value::None,
            0x88 => Value::Bool(true),
            0x89 => Value::Bool(false),
            b'K' => Value::Int(i64::from(self.take(1)?[0])),
            b'M' => Value::Int(i64::from(u16::from_le_bytes(self.array()?))),
            b'J' => Value::Int(i64::from(i32::from_le_bytes(self.array()?))),
            b'G' => Value::Float(f64::from_be_bytes(self.array()?)),
            0x8c | b'X' => {
                let length = self.number()?;
                Value::Text(self.text(length, "text that is not UTF-8")?)
            }
            b'C' | b'B' => {
                let length = self.number()?;
                Value::Bytes(Rc::from(self.take(length)?))
            }
            b'}' => Value::Dict(vec![]),
            b')' => Value::Tuple(Rc::new(vec![])),
            b'c' => Value::Global { module: self.line()?, name: self.line()? },
            0x93 => match (self.pop()?.0, self.pop()?.0) {
                (Value::Text(name), Value::Text(module)) => Value::Global { module, name },
                _ => return Err(self.broken("a name that is not text")),
            },
            _ => {
                self.rearrange()?;
                return Ok(None);
            }
        };
        self.stack.push(Some((value, 0)));
        Ok(None)
    }

    /// Does any other opcode: most work on what lies on the stack.
    fn rearrange(&mut self) -> Result<(), ModelError> {
        match self.opcode {
            0x80 => match self.take(1)?[0] {
                2..=5 => Ok(()),
                _ => Err(self.broken("a protocol other than 2 to 5")),
            },
            0x95 => self.take(8).map(drop), // FRAME: a hint for buffering
            b'(' => {
                self.stack.push(None);
                Ok(())
            }
            0x85..=0x87 => {
                let mut popped = Vec::new();
                for _ in 0x85..=self.opcode {
                    popped.push(self.pop()?);
                }
                let (items, depths): (_, Vec<u8>) = popped.into_iter().rev().unzip();
                self.nest(Value::Tuple(Rc::new(items)), deepest(&depths))
            }
            b't' => {
                let (items, depth) = self.pop_to_mark()?;
                self.nest(Value::Tuple(Rc::new(items)), depth)
            }
            b's' => {
                let ((key, value), depth) = self.pop_two()?;
                self.set_items(vec![key, value], depth)
            }
            b'u' => {
                let (items, depth) = self.pop_to_mark()?;
                self.set_items(items, depth)
            }
            b'R' | 0x81 => {
                let (call, depth) = self.pop_two()?;
                if !call.0.is_global(&["collections"], "OrderedDict") {
                    return self.nest(Value::Call(Rc::new(call)), depth);
                }
                self.stack.push(Some((Value::Dict(vec![]), 0)));
                Ok(())
            }
            b'b' => {
                let (object_and_state, depth) = self.pop_two()?;
                self.nest(Value::Built(Rc::new(object_and_state)), depth)
            }
            b'Q' => {
                let (value, depth) = self.pop()?;
                self.nest(Value::Persistent(Rc::new(value)), depth)
            }
            b'q' | b'r' => {
                let index = self.number()?;
                self.remember(index)
            }
            0x94 => self.remember(self.memo.len()),
            b'h' | b'j' => {
                let index = self.number()?;
                self.recall(index)
            }
            _ => Err(self.broken("an opcode that flat dictionaries of arrays do not use")),
        }
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

    /// The length or place after an opcode: four bytes for the long forms, else one.
    fn number(&mut self) -> Result<usize, ModelError> {
        Ok(match self.opcode {
            b'X' | b'B' | b'r' | b'j' => u32::from_le_bytes(self.array()?) as usize,
            _ => usize::from(self.take(1)?[0]),
        })
    }

    fn text(&mut self, length: usize, problem: &'static str) -> Result<Rc<str>, ModelError> {
        let text: Option<Rc<str>> = std::str::from_utf8(self.take(length)?).ok().map(Rc::from);
        text.ok_or_else(|| self.broken(problem))
    }

    fn line(&mut self) -> Result<Rc<str>, ModelError> {
        let Some(length) = self.bytes[self.at..].iter().position(|byte| *byte == b'\n') else {
            return Err(self.broken("a name without an end"));
        };
        let text = self.text(length, "a name that is not UTF-8")?;
        self.take(1)?;
        Ok(text)
    }

    /// Pushes a value that holds others, the deepest of which has `depth`.
    fn nest(&mut self, value: Value, depth: u8) -> Result<(), ModelError> {
        if depth >= DEEPEST {
            return Err(self.broken("nested deeper than any file of this kind"));
        }
        self.stack.push(Some((value, depth + 1)));
        Ok(())
    }

    fn pop(&mut self) -> Result<(Value, u8), ModelError> {
        match self.stack.pop() {
            Some(Some(value)) => Ok(value),
            Some(None) => Err(self.broken("a mark where a value should be")),
            None => Err(self.broken("nothing to work on")),
        }
    }

    /// The two values on top, the lower one first, and the depth of the deeper one.
    fn pop_two(&mut self) -> Result<((Value, Value), u8), ModelError> {
        let (upper, deep_upper) = self.pop()?;
        let (lower, deep_lower) = self.pop()?;
        Ok(((lower, upper), deep_upper.max(deep_lower)))
    }

    fn pop_to_mark(&mut self) -> Result<(Vec<Value>, u8), ModelError> {
        let Some(mark) = self.stack.iter().rposition(Option::is_none) else {
            return Err(self.broken("no mark"));
        };
        let (items, depths): (_, Vec<u8>) = self.stack.drain(mark..).flatten().unzip();
        Ok((items, deepest(&depths)))
    }

    fn set_items(&mut self, items: Vec<Value>, depth: u8) -> Result<(), ModelError> {
        let (value, own) = self.pop()?;
        let Value::Dict(mut entries) = value else {
            return Err(self.broken("items for something that is not a dictionary"));
        };
        let mut items = items.into_iter();
        while let Some(key) = items.next() {
            let value = items.next().ok_or_else(|| self.broken("a key without a value"))?;
            entries.push((key, value));
        }
        // nest adds one level; a dictionary that already has it keeps it.
        self.nest(Value::Dict(entries), depth.max(own.saturating_sub(1)))
    }

    fn remember(&mut self, index: usize) -> Result<(), ModelError> {
        let Some(Some((value, depth))) = self.stack.last() else {
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
            Some(value @ Some(_)) => {
                self.stack.push(value.clone());
                Ok(())
            }
            Some(None) => Err(self.broken("a second reference to a dictionary")),
            None => Err(self.broken("a memory place that was never filled")),
        }
    }
}

fn deepest(depths: &[u8]) -> u8 {
    depths.iter().copied().max().unwrap_or(0)
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
