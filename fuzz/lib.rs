//! Fuzz targets for every reader of files: each has the sound file of its kind, damaged, read in its place.
//! How they are run: `fuzz/run`.

#[path = "../crates/scenario/tests/file_readers/mod.rs"]
mod file_readers;

pub use file_readers::ReaderAtWork;

/// Where `file_readers` is, from this crate.
const HERE: &str = "../crates/scenario/tests/file_readers";

/// The entry point of the fuzz target for the reader of this name.
#[macro_export]
macro_rules! fuzz_reader {
    ($name:literal) => {
        thread_local! {
            static READER: $crate::ReaderAtWork = $crate::ReaderAtWork::new($name);
        }
        libfuzzer_sys::fuzz_target!(|bytes: &[u8]| READER.with(|reader| reader.read(bytes)));
    };
}
