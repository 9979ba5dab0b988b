//! Thrift's compact protocol, as far as the metadata of Parquet use it.
//!
//! Source: Apache Thrift, `doc/specs/thrift-compact-protocol.md`, whole.

use std::collections::BTreeMap;

/// A value of the compact protocol.
#[derive(Clone, Debug, PartialEq)]
pub enum Thrift {
    Bool(bool),
    /// 32-bit integer, which also stands for enumerations.
    I32(i64),
    I64(i64),
    Binary(Vec<u8>),
    List(Vec<Thrift>),
    Struct(BTreeMap<i16, Thrift>),
}

/// Types of the compact protocol.
const TRUE: u8 = 1;
const FALSE: u8 = 2;
const BYTE: u8 = 3;
const I16: u8 = 4;
const I32: u8 = 5;
const I64: u8 = 6;
const DOUBLE: u8 = 7;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const SET: u8 = 10;
const STRUCT: u8 = 12;

/// Greatest depth of structs and lists in each other; metadata of Parquet have six.
const MOST_DEPTH: usize = 16;

impl Thrift {
    /// Creates a struct of fields with their numbers.
    pub fn fields(fields: impl IntoIterator<Item = (i16, Thrift)>) -> Self {
        Self::Struct(fields.into_iter().collect())
    }

    /// Creates a text.
    pub fn text(text: &str) -> Self {
        Self::Binary(text.as_bytes().to_vec())
    }

    /// Field of a struct.
    pub fn field(&self, number: i16) -> Option<&Self> {
        match self {
            Self::Struct(fields) => fields.get(&number),
            _ => None,
        }
    }

    /// Value of an integer.
    pub fn integer(&self) -> Option<i64> {
        match self {
            Self::I32(value) | Self::I64(value) => Some(*value),
            _ => None,
        }
    }

    /// Elements of a list.
    pub fn elements(&self) -> Option<&[Self]> {
        match self {
            Self::List(elements) => Some(elements),
            _ => None,
        }
    }

    /// Text of a binary value.
    pub fn as_text(&self) -> Option<&str> {
        match self {
            Self::Binary(bytes) => std::str::from_utf8(bytes).ok(),
            _ => None,
        }
    }

    fn kind(&self) -> u8 {
        match self {
            Self::Bool(true) => TRUE,
            Self::Bool(false) => FALSE,
            Self::I32(_) => I32,
            Self::I64(_) => I64,
            Self::Binary(_) => BINARY,
            Self::List(_) => LIST,
            Self::Struct(_) => STRUCT,
        }
    }

    /// Appends the value.
    pub fn write(&self, bytes: &mut Vec<u8>) {
        match self {
            // As a field, its type holds the value; no list of truth values occurs.
            Self::Bool(_) => {}
            Self::I32(value) | Self::I64(value) => write_varint(zigzag(*value), bytes),
            Self::Binary(content) => {
                write_varint(content.len() as u64, bytes);
                bytes.extend_from_slice(content);
            }
            Self::List(elements) => {
                let kind = elements.first().map_or(STRUCT, Self::kind);
                match u8::try_from(elements.len()) {
                    Ok(count) if count < 15 => bytes.push((count << 4) | kind),
                    _ => {
                        bytes.push(0xf0 | kind);
                        write_varint(elements.len() as u64, bytes);
                    }
                }
                for element in elements {
                    element.write(bytes);
                }
            }
            Self::Struct(fields) => {
                let mut last = 0;
                for (number, value) in fields {
                    match u8::try_from(number - last) {
                        Ok(step) if (1..16).contains(&step) => bytes.push((step << 4) | value.kind()),
                        _ => {
                            bytes.push(value.kind());
                            write_varint(zigzag(i64::from(*number)), bytes);
                        }
                    }
                    last = *number;
                    value.write(bytes);
                }
                bytes.push(0);
            }
        }
    }

    /// Reads a struct from the beginning of `bytes`, and returns it with the number of bytes that it takes; `None` if they are no
    /// struct of the compact protocol.
    pub fn read(bytes: &[u8]) -> Option<(Self, usize)> {
        let mut reader = Reader { bytes, at: 0 };
        let value = reader.value(STRUCT, 0)?;
        Some((value, reader.at))
    }
}

fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)).cast_unsigned()
}

/// Appends a number in groups of seven bits, the lowest first.
pub(crate) fn write_varint(mut value: u64, bytes: &mut Vec<u8>) {
    let low = |value: u64| value.to_le_bytes()[0];
    while value >= 0x80 {
        bytes.push(low(value) | 0x80);
        value >>= 7;
    }
    bytes.push(low(value));
}

/// Reads a number that [`write_varint`] wrote, and moves `at` behind it; `None` if it ends too early or is too large.
pub(crate) fn read_varint(bytes: &[u8], at: &mut usize) -> Option<u64> {
    let mut value = 0_u64;
    for group in 0..10 {
        let byte = *bytes.get(*at)?;
        *at += 1;
        value |= u64::from(byte & 0x7f).checked_shl(7 * group)?;
        if byte < 0x80 {
            return Some(value);
        }
    }
    None
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn integer(&mut self) -> Option<i64> {
        let value = read_varint(self.bytes, &mut self.at)?;
        Some((value >> 1).cast_signed() ^ -(value & 1).cast_signed())
    }

    fn count(&mut self) -> Option<usize> {
        let count = usize::try_from(read_varint(self.bytes, &mut self.at)?).ok()?;
        // Each element takes a byte at least.
        (count <= self.bytes.len() - self.at).then_some(count)
    }

    fn value(&mut self, kind: u8, depth: usize) -> Option<Thrift> {
        if depth > MOST_DEPTH {
            return None;
        }
        Some(match kind {
            TRUE => Thrift::Bool(true),
            FALSE => Thrift::Bool(false),
            BYTE => Thrift::I32(i64::from(self.byte()?.cast_signed())),
            I16 | I32 => Thrift::I32(self.integer()?),
            I64 => Thrift::I64(self.integer()?),
            DOUBLE | BINARY => {
                let count = if kind == DOUBLE { 8 } else { self.count()? };
                let content = self.bytes.get(self.at..self.at.checked_add(count)?)?.to_vec();
                self.at += count;
                Thrift::Binary(content)
            }
            LIST | SET => {
                let head = self.byte()?;
                let count = if head >> 4 == 15 { self.count()? } else { usize::from(head >> 4) };
                // A truth value in a list is a byte of its own.
                let of = if head & 15 <= FALSE { BYTE } else { head & 15 };
                let mut elements = Vec::new();
                for _ in 0..count {
                    elements.push(self.value(of, depth + 1)?);
                }
                Thrift::List(elements)
            }
            STRUCT => {
                let (mut fields, mut last) = (BTreeMap::new(), 0_i16);
                loop {
                    let head = self.byte()?;
                    if head == 0 {
                        break;
                    }
                    last = match head >> 4 {
                        0 => i16::try_from(self.integer()?).ok()?,
                        step => last.checked_add(i16::from(step))?,
                    };
                    fields.insert(last, self.value(head & 15, depth + 1)?);
                }
                Thrift::Struct(fields)
            }
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes are those of the specification's examples: field 1 with an `i32` of 1 is `15 02`, a text of two letters in field 4
    /// `38 02 61 62`.
    #[test]
    fn structs_are_those_of_the_specification() {
        let value = Thrift::fields([(1, Thrift::I32(1)), (4, Thrift::text("ab")), (40, Thrift::Bool(true))]);
        let mut bytes = Vec::new();
        value.write(&mut bytes);
        assert_eq!(bytes, [0x15, 0x02, 0x38, 0x02, 0x61, 0x62, 0x01, 80, 0x00]);
        assert_eq!(Thrift::read(&bytes), Some((value, bytes.len())));
        for end in 0..bytes.len() {
            assert_eq!(Thrift::read(&bytes[..end]), None);
        }
    }

    #[test]
    fn lists_and_numbers_return() {
        let numbers = [0, -1, 1, i64::MIN, i64::MAX, 300].map(Thrift::I64).to_vec();
        let value = Thrift::fields([(2, Thrift::List(numbers)), (3, Thrift::List(vec![Thrift::I32(7); 20]))]);
        let mut bytes = Vec::new();
        value.write(&mut bytes);
        assert_eq!(Thrift::read(&bytes), Some((value, bytes.len())));
    }
}
