//! No file makes a reader of campaigns panic or take for ever: sound ones damaged at random or grown, and the cases
//! that fuzzing has found.

mod file_readers;

use std::fs;
use std::time::Instant;

use file_readers::{FILE_READERS, ReaderAtWork, cases};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

/// Where `file_readers` is, in this crate.
const HERE: &str = "tests/file_readers";

#[test]
fn every_case_is_read_or_refused() {
    for reader in &FILE_READERS {
        let at_work = ReaderAtWork::new(reader.name);
        at_work.read(reader.sound);
        for entry in fs::read_dir(cases().join(reader.name)).into_iter().flatten() {
            let path = entry.expect("a case").path();
            println!("{}", path.display());
            at_work.read(&fs::read(path).expect("a case"));
        }
    }
}

#[test]
fn damaged_input_is_read_or_refused() {
    for reader in &FILE_READERS {
        let at_work = ReaderAtWork::new(reader.name);
        let mut runner =
            TestRunner::new(ProptestConfig { source_file: Some(file!()), ..ProptestConfig::default() });
        let edits =
            prop::collection::vec((0.0..1.0, 0..4_usize, prop::collection::vec(any::<u8>(), 0..6)), 1..4);
        let result = runner.run(&edits, |edits| {
            let mut bytes = reader.sound.to_vec();
            for (share, removed, put) in edits {
                // Inputs are short.
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let at = ((share * bytes.len() as f64) as usize).min(bytes.len());
                bytes.splice(at..(at + removed).min(bytes.len()), put);
            }
            at_work.read(&bytes);
            Ok(())
        });
        result.unwrap_or_else(|fault| panic!("{}: {fault}", reader.name));
    }
}

/// What takes time with the square of its size shows in an input that is the same again and again.
#[test]
fn grown_input_is_read_or_refused_in_a_moment() {
    for reader in FILE_READERS.iter().filter(|reader| reader.sound.len() > 8) {
        let at_work = ReaderAtWork::new(reader.name);
        for (share, length) in [(3, 20), (5, 60), (7, 9)] {
            let at = reader.sound.len() * share / 8;
            let stretch = &reader.sound[at..(at + length).min(reader.sound.len())];
            let grown =
                [&reader.sound[..at], &stretch.repeat(1_000_000 / stretch.len()), &reader.sound[at..]]
                    .concat();
            let begin = Instant::now();
            at_work.read(&grown);
            assert!(begin.elapsed().as_secs() < 10, "{} at {at}: {:?}", reader.name, begin.elapsed());
        }
    }
}
