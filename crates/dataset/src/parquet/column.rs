/// Values of one column of a table, one entry per row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Column {
    /// True or false.
    Bool(Vec<bool>),
    /// 32-bit integers.
    Int32(Vec<i32>),
    /// 64-bit integers.
    Int64(Vec<i64>),
    /// Single precision.
    Float(Vec<f32>),
    /// Double precision.
    Double(Vec<f64>),
    /// Texts.
    Text(Vec<String>),
    /// Bytes of any content.
    Bytes(Vec<Vec<u8>>),
    /// Lists of 32-bit integers.
    Int32s(Vec<Vec<i32>>),
    /// Lists in single precision.
    Floats(Vec<Vec<f32>>),
    /// Lists in double precision.
    Doubles(Vec<Vec<f64>>),
    /// Lists of texts.
    Texts(Vec<Vec<String>>),
}

/// Physical types of Parquet, with their numbers.
pub(crate) const BOOLEAN: i64 = 0;
pub(crate) const INT32: i64 = 1;
pub(crate) const INT64: i64 = 2;
pub(crate) const FLOAT: i64 = 4;
pub(crate) const DOUBLE: i64 = 5;
pub(crate) const BYTE_ARRAY: i64 = 6;

impl Column {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Bool(values) => values.len(),
            Self::Int32(values) => values.len(),
            Self::Int64(values) => values.len(),
            Self::Float(values) => values.len(),
            Self::Double(values) => values.len(),
            Self::Text(values) => values.len(),
            Self::Bytes(values) => values.len(),
            Self::Int32s(values) => values.len(),
            Self::Floats(values) => values.len(),
            Self::Doubles(values) => values.len(),
            Self::Texts(values) => values.len(),
        }
    }

    /// Returns the number of the physical type of its values.
    pub(crate) fn physical(&self) -> i64 {
        match self {
            Self::Bool(_) => BOOLEAN,
            Self::Int32(_) | Self::Int32s(_) => INT32,
            Self::Int64(_) => INT64,
            Self::Float(_) | Self::Floats(_) => FLOAT,
            Self::Double(_) | Self::Doubles(_) => DOUBLE,
            Self::Text(_) | Self::Bytes(_) | Self::Texts(_) => BYTE_ARRAY,
        }
    }

    /// Returns true if its values are texts.
    pub(crate) fn is_text(&self) -> bool {
        matches!(self, Self::Text(_) | Self::Texts(_))
    }

    /// Returns the number of elements of each row; `None` for a column without lists.
    pub(crate) fn lengths(&self) -> Option<Vec<usize>> {
        match self {
            Self::Int32s(rows) => Some(rows.iter().map(Vec::len).collect()),
            Self::Floats(rows) => Some(rows.iter().map(Vec::len).collect()),
            Self::Doubles(rows) => Some(rows.iter().map(Vec::len).collect()),
            Self::Texts(rows) => Some(rows.iter().map(Vec::len).collect()),
            _ => None,
        }
    }
}
