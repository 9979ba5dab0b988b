//! The readers of scenarios and of what they name.

#[path = "../crates/scenario/tests/file_readers/mod.rs"]
mod file_readers;

pub use file_readers::ReaderAtWork;

/// Where `file_readers` is, from this crate.
const HERE: &str = "../crates/scenario/tests/file_readers";
