#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "counts are far below 2^31, and single precision is the precision of the format"
)]

use crate::parquet::column::Column;
use crate::parquet::thrift::{Thrift, write_varint};

/// First and last bytes of a Parquet file.
pub(crate) const MAGIC: &[u8; 4] = b"PAR1";

/// Encodings, by their numbers.
pub(crate) const PLAIN: i64 = 0;
const RLE: i64 = 3;
/// Repetitions of a field.
const REQUIRED: i64 = 0;
const REPEATED: i64 = 2;
/// Converted types of a field.
const UTF8: i64 = 0;
const LIST: i64 = 3;

/// Returns the bytes of a Parquet file with these columns, which have the same number of rows. `notes` are key-value metadata.
pub(crate) fn parquet_file(columns: &[(&str, Column)], notes: &[(&str, &str)]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    let rows = columns.first().map_or(0, |(_, column)| column.len()) as i64;
    let root = [(4, Thrift::text("schema")), (5, Thrift::I32(columns.len() as i64))];
    let (mut schema, mut chunks, mut total) = (vec![Thrift::fields(root)], Vec::new(), 0);
    for (name, column) in columns {
        schema.extend(elements(name, column));
        let offset = bytes.len() as i64;
        let (levels, count) = levels(column);
        let mut page = levels;
        write_values(column, &mut page);
        let size = Thrift::I32(page.len() as i64);
        let of_data = [
            (1, Thrift::I32(count as i64)),
            (2, Thrift::I32(PLAIN)),
            (3, Thrift::I32(RLE)),
            (4, Thrift::I32(RLE)),
        ];
        let header = [(1, Thrift::I32(0)), (2, size.clone()), (3, size), (5, Thrift::fields(of_data))];
        Thrift::fields(header).write(&mut bytes);
        bytes.extend_from_slice(&page);
        let size = bytes.len() as i64 - offset;
        total += size;
        let mut path = vec![Thrift::text(name)];
        if column.lengths().is_some() {
            path.extend([Thrift::text("list"), Thrift::text("element")]);
        }
        let metadata = [
            (1, Thrift::I32(column.physical())),
            (2, Thrift::List(vec![Thrift::I32(PLAIN), Thrift::I32(RLE)])),
            (3, Thrift::List(path)),
            (4, Thrift::I32(0)),
            (5, Thrift::I64(count as i64)),
            (6, Thrift::I64(size)),
            (7, Thrift::I64(size)),
            (9, Thrift::I64(offset)),
        ];
        chunks.push(Thrift::fields([(2, Thrift::I64(offset)), (3, Thrift::fields(metadata))]));
    }
    let group = [(1, Thrift::List(chunks)), (2, Thrift::I64(total)), (3, Thrift::I64(rows))];
    let note =
        |(key, value): &(&str, &str)| Thrift::fields([(1, Thrift::text(key)), (2, Thrift::text(value))]);
    let mut footer = vec![
        (1, Thrift::I32(1)),
        (2, Thrift::List(schema)),
        (3, Thrift::I64(rows)),
        (4, Thrift::List(vec![Thrift::fields(group)])),
        (6, Thrift::text("cranny")),
    ];
    if !notes.is_empty() {
        footer.push((5, Thrift::List(notes.iter().map(note).collect())));
    }
    let begin = bytes.len();
    Thrift::fields(footer).write(&mut bytes);
    let length = (bytes.len() - begin) as u32;
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(MAGIC);
    bytes
}

/// Returns the elements of the schema for a column.
fn elements(name: &str, column: &Column) -> Vec<Thrift> {
    let leaf = |name: &str| {
        let mut fields =
            vec![(1, Thrift::I32(column.physical())), (3, Thrift::I32(REQUIRED)), (4, Thrift::text(name))];
        if column.is_text() {
            fields.push((6, Thrift::I32(UTF8)));
        }
        Thrift::fields(fields)
    };
    if column.lengths().is_none() {
        return vec![leaf(name)];
    }
    let list =
        [(3, Thrift::I32(REQUIRED)), (4, Thrift::text(name)), (5, Thrift::I32(1)), (6, Thrift::I32(LIST))];
    let repeated = [(3, Thrift::I32(REPEATED)), (4, Thrift::text("list")), (5, Thrift::I32(1))];
    vec![Thrift::fields(list), Thrift::fields(repeated), leaf("element")]
}

/// Returns the repetition and definition levels of a column, and the number of its values, an empty list counted as one.
///
/// Both levels are 0 or 1. In a list, the first value has repetition 0 and the others 1; definition is 0 for an empty list.
fn levels(column: &Column) -> (Vec<u8>, usize) {
    let Some(lengths) = column.lengths() else { return (Vec::new(), column.len()) };
    let (mut repetitions, mut definitions) = (Runs::default(), Runs::default());
    for length in &lengths {
        repetitions.add(0, 1);
        repetitions.add(1, length.saturating_sub(1));
        definitions.add(u8::from(*length > 0), (*length).max(1));
    }
    let mut bytes = Vec::new();
    for runs in [repetitions, definitions] {
        let runs = runs.into_bytes();
        bytes.extend_from_slice(&(runs.len() as u32).to_le_bytes());
        bytes.extend_from_slice(&runs);
    }
    (bytes, lengths.iter().map(|length| (*length).max(1)).sum())
}

/// Runs of equal levels, in the hybrid encoding of Parquet.
#[derive(Default)]
struct Runs {
    bytes: Vec<u8>,
    level: u8,
    count: usize,
}

impl Runs {
    fn add(&mut self, level: u8, count: usize) {
        if level != self.level && count > 0 {
            self.end();
            self.level = level;
        }
        self.count += count;
    }

    fn end(&mut self) {
        if self.count > 0 {
            write_varint((self.count as u64) << 1, &mut self.bytes);
            self.bytes.push(self.level);
        }
        self.count = 0;
    }

    fn into_bytes(mut self) -> Vec<u8> {
        self.end();
        self.bytes
    }
}

fn write_values(column: &Column, bytes: &mut Vec<u8>) {
    match column {
        Column::Bool(values) => {
            for eight in values.chunks(8) {
                bytes.push(
                    eight.iter().enumerate().fold(0, |byte, (bit, value)| byte | u8::from(*value) << bit),
                );
            }
        }
        Column::Int32(values) => bytes.extend(values.iter().flat_map(|value| value.to_le_bytes())),
        Column::Int64(values) => bytes.extend(values.iter().flat_map(|value| value.to_le_bytes())),
        Column::Float(values) => bytes.extend(values.iter().flat_map(|value| value.to_le_bytes())),
        Column::Double(values) => bytes.extend(values.iter().flat_map(|value| value.to_le_bytes())),
        Column::Int32s(rows) => bytes.extend(rows.iter().flatten().flat_map(|value| value.to_le_bytes())),
        Column::Floats(rows) => bytes.extend(rows.iter().flatten().flat_map(|value| value.to_le_bytes())),
        Column::Doubles(rows) => bytes.extend(rows.iter().flatten().flat_map(|value| value.to_le_bytes())),
        Column::Text(values) => write_texts(values, bytes),
        Column::Texts(rows) => {
            for values in rows {
                write_texts(values, bytes);
            }
        }
        Column::Bytes(values) => write_texts(values, bytes),
    }
}

fn write_texts(values: &[impl AsRef<[u8]>], bytes: &mut Vec<u8>) {
    for value in values {
        bytes.extend_from_slice(&(value.as_ref().len() as u32).to_le_bytes());
        bytes.extend_from_slice(value.as_ref());
    }
}
