//! The readers of campaigns.

#[path = "../crates/bench/tests/file_readers/mod.rs"]
mod file_readers;

pub use file_readers::ReaderAtWork;

/// Where `file_readers` is, from this crate.
const HERE: &str = "../crates/bench/tests/file_readers";
