use std::io::{self, BufReader, Read};

use crate::excerpt;

/// Reader of the numbers of a `NumPy` array (`.npy`, versions 1.0, 2.0 and 3.0; `NumPy`'s "NEP 1 — A simple file format for
/// `NumPy` arrays"), converted to `f64`, in the order of the file. Integers above 2⁵³ are rounded.
///
/// Yields as many numbers as the shape has, or an error of the kind [`io::ErrorKind::UnexpectedEof`] where the source ends
/// too early.
pub struct NpyArray<R> {
    /// Lengths of the dimensions.
    pub shape: Vec<u64>,
    /// True if the first index changes fastest (`fortran_order`).
    pub is_column_major: bool,
    /// Type of the numbers, as in the header: `'<f8'`.
    pub kind: String,
    source: BufReader<R>,
    number: Option<Number>,
    left: u64,
}

/// Maximum length of a header, in bytes: that of version 1.0. Those that `NumPy` writes for numbers have 128.
const MOST_HEADER_BYTES: usize = 65_535;

const MAGIC: &[u8; 6] = b"\x93NUMPY";

impl<R: Read> NpyArray<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// A sentence on a header that is cut short, too long, of another version, or has no valid shape and order.
    pub fn of(source: R) -> Result<Self, String> {
        let mut source = BufReader::new(source);
        let text = header_text(&mut source)?;
        let header = Header::parse(&text)?;
        let left = header.shape.iter().try_fold(1_u64, |all, side| all.checked_mul(*side));
        let left = left.ok_or_else(|| format!("its shape {:?} has too many numbers", header.shape))?;
        Ok(Self {
            number: Number::of(header.kind),
            kind: excerpt(header.kind),
            shape: header.shape,
            is_column_major: header.is_column_major,
            source,
            left,
        })
    }

    /// Returns true if the numbers can be read: floats of 4 or 8 bytes, integers of up to 8 bytes, or truth values.
    pub fn is_numeric(&self) -> bool {
        self.number.is_some()
    }

    /// Returns true if nothing follows what has been read.
    ///
    /// # Errors
    /// Those of the source.
    pub fn is_at_end(&mut self) -> io::Result<bool> {
        Ok(self.source.read(&mut [0])? == 0)
    }
}

impl<R: Read> Iterator for NpyArray<R> {
    type Item = io::Result<f64>;

    fn next(&mut self) -> Option<io::Result<f64>> {
        self.left = self.left.checked_sub(1)?;
        let number = self.number?.read(&mut self.source);
        if number.is_err() {
            self.left = 0;
        }
        Some(number)
    }
}

fn header_text(source: &mut impl Read) -> Result<String, String> {
    let mut bytes = |count: usize| {
        let mut bytes = vec![0; count];
        source.read_exact(&mut bytes).map_err(|reason| match reason.kind() {
            io::ErrorKind::UnexpectedEof => "the file ends within its header (was it cut short?)".to_owned(),
            _ => reason.to_string(),
        })?;
        Ok::<_, String>(bytes)
    };
    let begin = bytes(MAGIC.len() + 2)?;
    let size = match begin.strip_prefix(MAGIC) {
        Some([1, 0]) => u32::from(u16::from_le_bytes([bytes(1)?[0], bytes(1)?[0]])),
        Some([2 | 3, 0]) => u32::from_le_bytes([bytes(1)?[0], bytes(1)?[0], bytes(1)?[0], bytes(1)?[0]]),
        Some(version) => return Err(format!("version {version:?} of the format is not read")),
        None => return Err("it does not begin as a NumPy array".to_owned()),
    };
    let size = usize::try_from(size).unwrap_or(usize::MAX);
    if size > MOST_HEADER_BYTES {
        return Err(format!("its header has {size} bytes, but at most {MOST_HEADER_BYTES} are read"));
    }
    String::from_utf8(bytes(size)?).map_err(|_| "its header is no text".to_owned())
}

struct Header<'a> {
    kind: &'a str,
    is_column_major: bool,
    shape: Vec<u64>,
}

impl<'a> Header<'a> {
    /// Parses the dictionary, a literal of Python: `{'descr': '<f8', 'fortran_order': False, 'shape': (2, 4, 4), }`.
    ///
    /// # Errors
    /// A sentence on what is wrong.
    fn parse(text: &'a str) -> Result<Self, String> {
        let wrong = || format!("its header is no dictionary: {}", excerpt(text.trim()));
        let mut rest =
            text.trim().strip_prefix('{').and_then(|rest| rest.strip_suffix('}')).ok_or_else(wrong)?;
        let (mut kind, mut order, mut shape) = (None, None, None);
        while !rest.trim().is_empty() {
            let (entry, behind) = split_at_comma(rest).ok_or_else(wrong)?;
            let (key, value) = entry.split_once(':').ok_or_else(wrong)?;
            match unquoted(key.trim()).ok_or_else(wrong)? {
                "descr" => kind = Some(value.trim()),
                "fortran_order" => order = Some(value.trim()),
                "shape" => shape = Some(value.trim()),
                _ => {}
            }
            rest = behind;
        }
        let missing = |key: &str| format!("its header has no '{key}'");
        let (order, shape) =
            (order.ok_or_else(|| missing("fortran_order"))?, shape.ok_or_else(|| missing("shape"))?);
        Ok(Self {
            kind: kind.ok_or_else(|| missing("descr"))?,
            is_column_major: match order {
                "True" => true,
                "False" => false,
                other => return Err(format!("'fortran_order' is {}, not True or False", excerpt(other))),
            },
            shape: lengths(shape)
                .ok_or_else(|| format!("'shape' is {}, not a list of lengths", excerpt(shape)))?,
        })
    }
}

/// Splits at the first comma outside of brackets and texts; `None` if a bracket or a text does not end, or ends twice.
fn split_at_comma(text: &str) -> Option<(&str, &str)> {
    let (mut depth, mut quote, mut is_escaped) = (0_usize, None, false);
    for (at, byte) in text.bytes().enumerate() {
        match (quote, byte) {
            (Some(_), _) if is_escaped => is_escaped = false,
            (Some(_), b'\\') => is_escaped = true,
            (Some(open), _) if open == byte => quote = None,
            (None, b'\'' | b'"') => quote = Some(byte),
            (None, b'(' | b'[' | b'{') => depth += 1,
            (None, b')' | b']' | b'}') => depth = depth.checked_sub(1)?,
            (None, b',') if depth == 0 => return Some((&text[..at], &text[at + 1..])),
            _ => {}
        }
    }
    (depth == 0 && quote.is_none()).then_some((text, ""))
}

fn unquoted(text: &str) -> Option<&str> {
    ['\'', '"'].iter().find_map(|quote| text.strip_prefix(*quote)?.strip_suffix(*quote))
}

/// Lengths of a tuple or list.
fn lengths(text: &str) -> Option<Vec<u64>> {
    let is_tuple = text.starts_with('(');
    let ends = if is_tuple { ['(', ')'] } else { ['[', ']'] };
    let inside = text.strip_prefix(ends[0])?.strip_suffix(ends[1])?.trim();
    let listed = inside.strip_suffix(',').unwrap_or(inside);
    // Without a comma, the brackets of one number are those of a term.
    if inside.is_empty() || (is_tuple && !inside.contains(',')) {
        return inside.is_empty().then(Vec::new);
    }
    let is_length = |word: &str| word.bytes().all(|byte| byte.is_ascii_digit());
    listed.split(',').map(str::trim).map(|word| word.parse().ok().filter(|_| is_length(word))).collect()
}

/// Conversion of the bytes of a number, the least significant first and zeros behind them; `None` for invalid ones.
type Conversion = fn([u8; 8]) -> Option<f64>;

/// Type of a number: its size, byte order and conversion.
#[derive(Clone, Copy)]
struct Number {
    bytes: usize,
    is_big_endian: bool,
    from_little_endian: Conversion,
}

impl Number {
    /// Type of a number from its name in the header, with quotes; `None` for another one.
    fn of(kind: &str) -> Option<Self> {
        let kind = unquoted(kind)?;
        let (order, kind) = kind.split_at_checked(1)?;
        let (bytes, from_little_endian): (usize, Conversion) = match kind {
            "f8" => (8, |bytes| Some(f64::from_le_bytes(bytes))),
            "f4" => (4, |bytes| Some(f64::from(f32::from_le_bytes(first(bytes))))),
            "i8" => (8, |bytes| Some(i64::from_le_bytes(bytes) as f64)),
            "i4" => (4, |bytes| Some(f64::from(i32::from_le_bytes(first(bytes))))),
            "i2" => (2, |bytes| Some(f64::from(i16::from_le_bytes(first(bytes))))),
            "i1" => (1, |bytes| Some(f64::from(i8::from_le_bytes(first(bytes))))),
            "u8" => (8, |bytes| Some(u64::from_le_bytes(bytes) as f64)),
            "u4" => (4, |bytes| Some(f64::from(u32::from_le_bytes(first(bytes))))),
            "u2" => (2, |bytes| Some(f64::from(u16::from_le_bytes(first(bytes))))),
            "u1" => (1, |bytes| Some(f64::from(bytes[0]))),
            "b1" => (1, |bytes| (bytes[0] < 2).then(|| f64::from(bytes[0]))),
            _ => return None,
        };
        let is_big_endian = match order {
            "<" => false,
            ">" => true,
            "|" if bytes == 1 => false,
            _ => return None,
        };
        Some(Self { bytes, is_big_endian, from_little_endian })
    }

    fn read(self, source: &mut impl Read) -> io::Result<f64> {
        let mut bytes = [0; 8];
        let own = &mut bytes[..self.bytes];
        source.read_exact(own)?;
        if self.is_big_endian {
            own.reverse();
        }
        (self.from_little_endian)(bytes).ok_or_else(|| {
            io::Error::new(io::ErrorKind::InvalidData, format!("invalid truth value {}", bytes[0]))
        })
    }
}

fn first<const N: usize>(bytes: [u8; 8]) -> [u8; N] {
    std::array::from_fn(|index| bytes[index])
}

/// Returns the bytes in front of the numbers of an array in C order (version 1.0); `kind` is the type of the numbers, such as
/// `<f4`.
pub fn npy_header(kind: &str, shape: &[u64]) -> Vec<u8> {
    /// Divisor of the offset of the numbers in the file.
    const ALIGNMENT: usize = 16;
    let lengths = shape.iter().map(|length| format!("{length}, ")).collect::<Vec<_>>().concat();
    let dictionary = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({lengths}), }}");
    let before = MAGIC.len() + 4;
    let size = (before + dictionary.len() + 1).next_multiple_of(ALIGNMENT) - before;
    let mut bytes = [&MAGIC[..], &[1, 0]].concat();
    bytes.extend(u16::try_from(size).unwrap_or(u16::MAX).to_le_bytes());
    bytes.extend(format!("{dictionary:width$}\n", width = size - 1).bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes_of(dictionary: &str, numbers: &[u8]) -> Vec<u8> {
        let size = u16::try_from(dictionary.len()).unwrap();
        [&b"\x93NUMPY\x01\x00"[..], &size.to_le_bytes(), dictionary.as_bytes(), numbers].concat()
    }

    fn numbers_of(kind: &str, numbers: &[u8]) -> Vec<f64> {
        let text = format!("{{\"shape\": [2], 'descr': {kind}, 'fortran_order': False}}\n");
        NpyArray::of(&bytes_of(&text, numbers)[..]).unwrap().collect::<Result<_, _>>().unwrap()
    }

    fn fault_of(dictionary: &str) -> String {
        NpyArray::of(&bytes_of(dictionary, &[])[..]).map(|array| array.shape).unwrap_err()
    }

    #[test]
    fn numbers_of_each_type_and_byte_order_are_read() {
        assert_eq!(
            numbers_of("'<f8'", &[0.1_f64.to_le_bytes(), (-2.5_f64).to_le_bytes()].concat()),
            [0.1, -2.5]
        );
        assert_eq!(numbers_of("'>f8'", &[0.1_f64.to_be_bytes(), 4_f64.to_be_bytes()].concat()), [0.1, 4.0]);
        assert_eq!(numbers_of("'>f4'", &[0.5_f32.to_be_bytes(), 4_f32.to_be_bytes()].concat()), [0.5, 4.0]);
        assert_eq!(numbers_of("'<i8'", &[(-7_i64).to_le_bytes(), 7_i64.to_le_bytes()].concat()), [-7.0, 7.0]);
        assert_eq!(numbers_of("'>i4'", &[(-7_i32).to_be_bytes(), 7_i32.to_be_bytes()].concat()), [-7.0, 7.0]);
        assert_eq!(numbers_of("'<i2'", &[(-7_i16).to_le_bytes(), 7_i16.to_le_bytes()].concat()), [-7.0, 7.0]);
        assert_eq!(numbers_of("'>u8'", &[1_u64.to_be_bytes(), 7_u64.to_be_bytes()].concat()), [1.0, 7.0]);
        assert_eq!(numbers_of("'<u4'", &[1_u32.to_le_bytes(), 7_u32.to_le_bytes()].concat()), [1.0, 7.0]);
        assert_eq!(numbers_of("'>u2'", &[1_u16.to_be_bytes(), 7_u16.to_be_bytes()].concat()), [1.0, 7.0]);
        assert_eq!(numbers_of("'|i1'", &[255, 1]), [-1.0, 1.0]);
        assert_eq!(numbers_of("\"|u1\"", &[255, 1]), [255.0, 1.0]);
        assert_eq!(numbers_of("'|b1'", &[1, 0]), [1.0, 0.0]);
    }

    #[test]
    fn a_written_header_is_read_back() {
        for shape in [&[][..], &[0], &[7], &[3, 4, 4]] {
            let bytes = npy_header("<f4", shape);
            assert_eq!(bytes.len() % 16, 0);
            let array = NpyArray::of(&bytes[..]).unwrap();
            assert_eq!((&array.shape[..], &*array.kind, array.is_column_major), (shape, "'<f4'", false));
        }
    }

    #[test]
    fn other_keys_and_types_are_passed_over() {
        let text = "{'descr': [('a', '<f8', (2,)), ('}', '<i4')], 'x': {'y': [1, 2]}, 'fortran_order': True, 'shape': (2,)}";
        let mut array = NpyArray::of(io::Cursor::new(bytes_of(text, &[]))).unwrap();
        assert!(array.is_column_major && !array.is_numeric() && array.next().is_none());
        assert_eq!(array.kind, "[('a', '<f8', (2,)), ('}', '<i4')]");
        for kind in ["'<U5'", "'|O'", "'<c16'", "'|f8'", "'=f8'", "'f8'", "'<f2'", "3", "''"] {
            let text = format!("{{'descr': {kind}, 'fortran_order': False, 'shape': ()}}");
            assert!(!NpyArray::of(&bytes_of(&text, &[])[..]).unwrap().is_numeric(), "{kind}");
        }
    }

    #[test]
    fn numbers_end_where_the_file_does() {
        let text = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,)}";
        let one = 1_f64.to_le_bytes();
        let mut short = NpyArray::of(io::Cursor::new(bytes_of(text, &one))).unwrap();
        assert_eq!(short.next().unwrap().unwrap().to_bits(), 1_f64.to_bits());
        assert_eq!(short.next().unwrap().unwrap_err().kind(), io::ErrorKind::UnexpectedEof);
        assert!(short.next().is_none());
        for (rest, is_at_end) in [(&[][..], true), (&[0], false)] {
            let bytes = bytes_of(text, &[&one, &one, rest].concat());
            let mut array = NpyArray::of(&bytes[..]).unwrap();
            assert!(array.by_ref().all(|number| number.is_ok()));
            assert_eq!(array.is_at_end().unwrap(), is_at_end);
        }
        let truth = "{'descr': '|b1', 'fortran_order': False, 'shape': (1,)}";
        assert!(NpyArray::of(&bytes_of(truth, &[2])[..]).unwrap().next().unwrap().is_err());
    }

    /// Guards against exponential time: a parser of Python took over 30 s for 3000 brackets.
    #[test]
    fn an_invalid_header_is_refused_at_once() {
        let brackets = "[".repeat(30_000);
        let pairs = brackets.clone() + &"]".repeat(30_000);
        let with = |kind: &str, order: &str, shape: &str| {
            format!("{{'descr': {kind}, 'fortran_order': {order}, 'shape': {shape}}}")
        };
        for (text, words) in [
            (with(&brackets, "False", "(1,)"), "no dictionary"),
            (with("'<f8'", "False", &brackets), "no dictionary"),
            (brackets.clone(), "no dictionary"),
            (with("'<f8'", "False", &pairs), "'shape' is [[["),
            (with("'<f8'", &pairs, "(1,)"), "'fortran_order' is [[["),
            (with("'<f8'", "0", "(1,)"), "not True or False"),
            (with("'<f8'", "False", "(1, -2)"), "not a list of lengths"),
            (with("'<f8'", "False", "(1,,2)"), "not a list of lengths"),
            (with("'<f8'", "False", "(+1,)"), "not a list of lengths"),
            (with("'<f8'", "False", "(3)"), "not a list of lengths"),
            (with("'<f8'", "False", "(1, 2]"), "not a list of lengths"),
            (with("'<f8'", "False", "(18446744073709551615, 4)"), "too many numbers"),
            (with("'<f8", "False", "(1,)"), "no dictionary"),
            ("{'descr': '<f8', 'shape': (1,)}".to_owned(), "no 'fortran_order'"),
            ("{}".to_owned(), "has no"),
        ] {
            let fault = fault_of(&text);
            assert!(fault.contains(words), "no '{words}' in {fault}");
            assert!(fault.chars().count() < 200, "{fault}");
        }
        // A descriptor of any depth is a type that is not read.
        assert!(
            NpyArray::of(&bytes_of(&with(&pairs, "False", "()"), &[])[..])
                .is_ok_and(|array| !array.is_numeric())
        );
        for (bytes, words) in [
            (&b""[..], "within its header"),
            (b"\x93NUMPY\x01\x00\xff\xff{", "within its header"),
            (b"\x93NUMPX\x01\x00\x01\x00{", "does not begin"),
            (b"\x93NUMPY\x04\x00\x01\x00{", "version [4, 0]"),
            (b"\x93NUMPY\x02\x00\xff\xff\xff\xff{", "4294967295 bytes, but at most 65535"),
            (b"\x93NUMPY\x01\x00\x01\x00\xff", "no text"),
        ] {
            let fault = NpyArray::of(bytes).map(|array| array.shape).unwrap_err();
            assert!(fault.contains(words), "no '{words}' in {fault}");
        }
    }
}
