//! Conversions between Python and Rust: arrays, rows, names, JSON, pickles, errors, and interruption by Ctrl-C.

pub mod array;
pub mod fault;
pub mod file_limits;
pub mod interrupt;
pub mod json;
pub mod names;
pub mod pickled;
pub mod rows;
pub mod whole;
