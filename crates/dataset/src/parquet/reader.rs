use std::collections::BTreeSet;

use crate::parquet::column::{BOOLEAN, BYTE_ARRAY, Column, DOUBLE, FLOAT, INT32, INT64};
use crate::parquet::thrift::{Thrift, read_varint};
use crate::parquet::writer::{MAGIC, PLAIN};

/// Columns of a Parquet file, by name, in their order.
pub(crate) type Table = Vec<(String, Column)>;

/// Reads a Parquet file as [`parquet_file`](crate::parquet::writer::parquet_file) writes them.
///
/// # Errors
/// A fault in words: a damaged file, or one in another encoding.
pub(crate) fn read_parquet(bytes: &[u8]) -> Result<Table, String> {
    let damaged = || "the file is damaged, or no Parquet file".to_owned();
    let body = bytes.strip_suffix(MAGIC).filter(|_| bytes.starts_with(MAGIC)).ok_or_else(damaged)?;
    let (rest, length) = body.split_last_chunk::<4>().ok_or_else(damaged)?;
    let begin = rest.len().checked_sub(u32::from_le_bytes(*length) as usize).ok_or_else(damaged)?;
    let (footer, _) = Thrift::read(&rest[begin..]).ok_or_else(damaged)?;
    read_columns(rest, &footer).ok_or_else(damaged)?
}

/// Reads all columns; `None` for damaged metadata.
fn read_columns(bytes: &[u8], footer: &Thrift) -> Option<Result<Table, String>> {
    let rows = usize::try_from(footer.field(3)?.integer()?).ok()?;
    // Each table has a column of numbers of eight bytes.
    if rows > bytes.len() / 8 {
        return None;
    }
    let mut offsets = BTreeSet::new();
    let groups = footer.field(4)?.elements()?;
    let [group] = groups else {
        return Some(Err(format!("the file has {} row groups, but one is expected", groups.len())));
    };
    let mut schema = footer.field(2)?.elements()?.iter().skip(1);
    let mut table = Vec::new();
    for chunk in group.field(1)?.elements()? {
        let mut element = schema.next()?;
        let name = element.field(4)?.as_text()?.to_owned();
        let is_list = element.field(5).is_some();
        if is_list {
            schema.next()?;
            element = schema.next()?;
        }
        let is_text = element.field(6).and_then(Thrift::integer) == Some(0);
        let metadata = chunk.field(3)?;
        let is_plain = metadata.field(4)?.integer()? == 0;
        let offset = usize::try_from(metadata.field(9)?.integer()?).ok()?;
        if !offsets.insert(offset) {
            return Some(Err(format!("column '{name}' has the page of another column")));
        }
        let (header, size) = Thrift::read(bytes.get(offset..)?)?;
        let of_page = header.field(5)?;
        if !is_plain || of_page.field(2)?.integer()? != PLAIN {
            return Some(Err(format!(
                "column '{name}' is compressed or encoded, but plain values are expected"
            )));
        }
        let begin = offset.checked_add(size)?;
        let end = begin.checked_add(usize::try_from(header.field(3)?.integer()?).ok()?)?;
        let mut page = Page { bytes: bytes.get(begin..end)?, at: 0 };
        let count = usize::try_from(of_page.field(1)?.integer()?).ok()?;
        let kind = Kind { physical: metadata.field(1)?.integer()?, is_text };
        // A list without values has one level, and each value at least four bytes.
        if count > rows + page.bytes.len() / 4 && is_list {
            return None;
        }
        let column = if is_list { page.lists(kind, count)? } else { page.values(kind, count)? };
        if column.len() != rows {
            return None;
        }
        table.push((name, column));
    }
    Some(Ok(table))
}

/// Kind of the values of a column.
#[derive(Clone, Copy)]
struct Kind {
    physical: i64,
    is_text: bool,
}

/// Content of a page that is not yet read.
struct Page<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Page<'_> {
    fn values(&mut self, Kind { physical, is_text }: Kind, count: usize) -> Option<Column> {
        Some(match physical {
            BOOLEAN => {
                let bytes = self.take(count.div_ceil(8))?;
                Column::Bool((0..count).map(|row| bytes[row / 8] >> (row % 8) & 1 == 1).collect())
            }
            INT32 => Column::Int32(self.numbers(count, i32::from_le_bytes)?),
            INT64 => Column::Int64(self.numbers(count, i64::from_le_bytes)?),
            FLOAT => Column::Float(self.numbers(count, f32::from_le_bytes)?),
            DOUBLE => Column::Double(self.numbers(count, f64::from_le_bytes)?),
            BYTE_ARRAY => {
                // Each value has its length in four bytes.
                if count > self.bytes.len() / 4 {
                    return None;
                }
                let mut values = Vec::with_capacity(count);
                for _ in 0..count {
                    let length = u32::from_le_bytes(self.take(4)?.try_into().ok()?) as usize;
                    values.push(self.take(length)?.to_vec());
                }
                if is_text {
                    Column::Text(values.into_iter().map(String::from_utf8).collect::<Result<_, _>>().ok()?)
                } else {
                    Column::Bytes(values)
                }
            }
            _ => return None,
        })
    }

    fn lists(&mut self, kind: Kind, count: usize) -> Option<Column> {
        let (repetitions, definitions) = (self.levels(count)?, self.levels(count)?);
        let mut lengths: Vec<usize> = Vec::new();
        for (repetition, definition) in repetitions.iter().zip(&definitions) {
            if *repetition == 0 {
                lengths.push(usize::from(*definition));
            } else {
                *lengths.last_mut()? += usize::from(*definition);
            }
        }
        let all = lengths.iter().sum();
        Some(match self.values(kind, all)? {
            Column::Int32(values) => Column::Int32s(split(values, &lengths)),
            Column::Float(values) => Column::Floats(split(values, &lengths)),
            Column::Double(values) => Column::Doubles(split(values, &lengths)),
            Column::Text(values) => Column::Texts(split(values, &lengths)),
            _ => return None,
        })
    }

    /// Reads levels of 0 and 1 in runs.
    fn levels(&mut self, count: usize) -> Option<Vec<u8>> {
        let length = u32::from_le_bytes(self.take(4)?.try_into().ok()?) as usize;
        let runs = self.take(length)?;
        let (mut levels, mut at) = (Vec::new(), 0);
        while at < runs.len() {
            let head = read_varint(runs, &mut at)?;
            let run = usize::try_from(head >> 1).ok()?;
            let level = *runs.get(at)?;
            at += 1;
            // A run of packed levels is not written here.
            if head & 1 == 1 || level > 1 || run > count - levels.len() {
                return None;
            }
            levels.resize(levels.len() + run, level);
        }
        (levels.len() == count).then_some(levels)
    }

    fn numbers<T, const SIZE: usize>(&mut self, count: usize, value: fn([u8; SIZE]) -> T) -> Option<Vec<T>> {
        let bytes = self.take(count.checked_mul(SIZE)?)?;
        let (values, _) = bytes.as_chunks::<SIZE>();
        Some(values.iter().map(|bytes| value(*bytes)).collect())
    }

    fn take(&mut self, count: usize) -> Option<&[u8]> {
        let taken = self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(taken)
    }
}

fn split<T>(values: Vec<T>, lengths: &[usize]) -> Vec<Vec<T>> {
    let mut values = values.into_iter();
    lengths.iter().map(|length| values.by_ref().take(*length).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parquet::writer::parquet_file;

    fn table() -> Vec<(&'static str, Column)> {
        vec![
            ("a", Column::Bool([true, false, true].repeat(3))),
            ("b", Column::Int32((0..9).collect())),
            ("c", Column::Int64((0..9).map(|n| n - (1 << 40)).collect())),
            ("d", Column::Float((0..9).map(|n| n as f32 / 3.0).collect())),
            ("e", Column::Double((0..9).map(|n| f64::from(n) / 3.0).collect())),
            ("f", Column::Text((0..9).map(|n| "ä".repeat(n)).collect())),
            ("g", Column::Bytes((0..9).map(|n| vec![n; 3]).collect())),
            ("h", Column::Doubles((0..9_u8).map(|n| vec![f64::from(n); usize::from(n) % 4]).collect())),
            ("i", Column::Texts((0..9).map(|n| vec!["x".to_owned(); n % 3]).collect())),
            ("j", Column::Int32s((0..9).map(|n| vec![n; 40]).collect())),
            ("k", Column::Floats(vec![Vec::new(); 9])),
        ]
    }

    /// `python/tests/test_dataset.py` compares the same content with pyarrow, the other oracle.
    #[test]
    fn a_file_returns_its_columns() {
        let table = table();
        let read = read_parquet(&parquet_file(&table, &[("key", "value")])).unwrap();
        let read: Vec<(&str, Column)> =
            read.iter().map(|(name, column)| (&name[..], column.clone())).collect();
        assert_eq!(read, table);
    }

    /// A run of levels states any number of empty lists in a few bytes.
    #[test]
    fn more_rows_than_a_file_has_room_for_are_refused() {
        let empty = parquet_file(&[("a", Column::Floats(vec![Vec::new(); 1_000_000]))], &[]);
        assert!(empty.len() < 1000 && read_parquet(&empty).is_err());
    }

    #[test]
    fn a_damaged_file_is_refused_or_read_as_something_else() {
        let sound = parquet_file(&table(), &[]);
        for end in (0..sound.len()).step_by(5) {
            assert!(read_parquet(&sound[..end]).is_err());
        }
        for at in (0..sound.len()).step_by(5) {
            for flip in [1, 0x80, 0xff] {
                let mut other = sound.clone();
                other[at] ^= flip;
                let _ = read_parquet(&other);
            }
        }
    }
}
