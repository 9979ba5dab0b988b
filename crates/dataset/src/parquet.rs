//! Parquet files: plain encoding, no compression, one row group and one page per column.
//!
//! Source of the layout: Apache Parquet, format 2.10, `parquet.thrift` and `Encodings.md`, whole.

pub(crate) mod column;
pub(crate) mod reader;
pub(crate) mod thrift;
pub(crate) mod writer;
