//! Values that cross between the interpreter and Rust: arrays, rows, JSON, pickles, faults, and the call that Ctrl-C ends.

pub mod array;
pub mod fault;
pub mod file_limits;
pub mod interrupt;
pub mod json;
pub mod pickled;
pub mod rows;
pub mod whole;
