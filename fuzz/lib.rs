//! Fuzz targets for every reader of files: each has the sound file of its kind, damaged, read in its place.
//! How they are run: `fuzz/run`.

#[path = "../crates/cli/tests/file_readers/mod.rs"]
mod file_readers;

pub use file_readers::ReaderAtWork;

/// Folder of `file_readers`, from this crate.
const HERE: &str = "../crates/cli/tests/file_readers";

/// Number of changes of which one repeats a stretch of the input until it is as long as it may be: what takes time or memory
/// with the square of a size shows in long files alone, which libFuzzer hardly makes by itself.
const GROWTH: u32 = 256;

/// Changes the first `size` of `data`, and returns how many bytes are then used.
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
