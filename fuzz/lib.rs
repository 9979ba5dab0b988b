//! Fuzz targets of all file readers: each reads damaged versions of a valid file of its kind. `fuzz/run` runs them.

#[path = "../crates/cli/tests/file_readers/mod.rs"]
mod file_readers;

pub use file_readers::ReaderAtWork;

/// Folder of `file_readers`, from this crate.
const HERE: &str = "../crates/cli/tests/file_readers";

/// One in this number of changes repeats a stretch of the input up to the maximum length: quadratic time or memory shows only
/// in long files, which libFuzzer rarely makes by itself.
const GROWTH: u32 = 256;

/// Changes the first `size` bytes of `data`, and returns the new size.
pub fn mutate(data: &mut [u8], size: usize, most: usize, seed: u32) -> usize {
    if seed % GROWTH != 0 || size == 0 {
        return libfuzzer_sys::fuzzer_mutate(data, size, most);
    }
    let draw = |salt: u32| (seed / GROWTH).wrapping_mul(salt) as usize;
    let at = draw(2_654_435_761) % size;
    let length = (1 + draw(40_503) % 256).min(size - at);
    let stretch = data[at..at + length].to_vec();
    let rest = data[at + length..size].to_vec();
    let times = (most - size) / length;
    let mut end = at + length;
    for _ in 0..times {
        data[end..end + length].copy_from_slice(&stretch);
        end += length;
    }
    data[end..end + rest.len()].copy_from_slice(&rest);
    end + rest.len()
}

/// The entry point of the fuzz target for the reader of this name.
#[macro_export]
macro_rules! fuzz_reader {
    ($name:literal) => {
        thread_local! {
            static READER: $crate::ReaderAtWork = $crate::ReaderAtWork::new($name);
        }
        libfuzzer_sys::fuzz_mutator!(|data: &mut [u8], size: usize, most: usize, seed: u32| {
            $crate::mutate(data, size, most, seed)
        });
        libfuzzer_sys::fuzz_target!(|bytes: &[u8]| READER.with(|reader| reader.read(bytes)));
    };
}
