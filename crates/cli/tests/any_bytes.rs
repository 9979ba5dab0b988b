//! Readers never panic: on sound files with random damage, and on the cases that fuzzing has found.

use std::fs;

use crate::file_readers::{FILE_READERS, FileReader, ReaderAtWork, here};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

/// Damage to a file.
#[derive(Clone, Debug)]
enum Damage {
    /// Truncation; positions are fractions of the length.
    CutAt(f64),
    /// Replacement of one byte.
    Byte(f64, u8),
    /// Removal of a range.
    Missing(f64, f64),
    /// Duplication of a range.
    Twice(f64, f64),
    /// Insertion of a difficult token.
    Inserted(f64, usize),
}

/// Numbers and tokens that are difficult for readers.
const HARD: [&[u8]; 14] = [
    b"-1",
    b"nan",
    b"1e999",
    b"18446744073709551616",
    b"4294967295",
    b"\0",
    b"\xff\xfe",
    b"\n",
    b"[",
    b"{",
    b"<",
    b"&a *a ",
    b"\"",
    b"0x",
];

fn damage() -> impl Strategy<Value = Damage> {
    let place = || 0.0..1.0;
    prop_oneof![
        place().prop_map(Damage::CutAt),
        (place(), any::<u8>()).prop_map(|(at, byte)| Damage::Byte(at, byte)),
        (place(), 0.0..0.2).prop_map(|(at, length)| Damage::Missing(at, length)),
        (place(), 0.0..0.2).prop_map(|(at, length)| Damage::Twice(at, length)),
        (place(), 0..HARD.len()).prop_map(|(at, what)| Damage::Inserted(at, what)),
    ]
}

impl Damage {
    fn applied_to(&self, bytes: &mut Vec<u8>) {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "files are short")]
        let place = |share: f64| ((share * bytes.len() as f64) as usize).min(bytes.len());
        match *self {
            Self::CutAt(at) => bytes.truncate(place(at)),
            Self::Byte(at, byte) => {
                let at = place(at);
                bytes.splice(at..(at + 1).min(bytes.len()), [byte]);
            }
            Self::Missing(at, length) => drop(bytes.drain(place(at)..place(at + length))),
            Self::Twice(at, length) => {
                let (begin, end) = (place(at), place(at + length));
                let stretch = bytes[begin..end].to_vec();
                bytes.splice(end..end, stretch);
            }
            Self::Inserted(at, what) => {
                let at = place(at);
                bytes.splice(at..at, HARD[what].iter().copied());
            }
        }
    }
}

/// Returns the sound file of a reader, and its further cases, by name.
fn cases(reader: &FileReader) -> Vec<(String, Vec<u8>)> {
    let mut cases = vec![("sound".to_owned(), fs::read(here().join("sound").join(reader.file)).unwrap())];
    let mut files: Vec<_> = fs::read_dir(here().join("cases").join(reader.name))
        .into_iter()
        .flatten()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    for path in files {
        cases.push((path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()));
    }
    cases
}

#[test]
fn every_case_is_read_or_refused() {
    for reader in &FILE_READERS {
        let at_work = ReaderAtWork::new(reader.name);
        for (name, bytes) in cases(reader) {
            println!("{}: {name}", reader.name);
            at_work.read(&bytes);
        }
    }
}

#[test]
fn damaged_files_are_read_or_refused() {
    for reader in &FILE_READERS {
        let at_work = ReaderAtWork::new(reader.name);
        let cases = cases(reader);
        let mut runner =
            TestRunner::new(ProptestConfig { source_file: Some(file!()), ..ProptestConfig::default() });
        let damaged = (0..cases.len(), prop::collection::vec(damage(), 1..4));
        let result = runner.run(&damaged, |(case, damages)| {
            let mut bytes = cases[case].1.clone();
            for damage in &damages {
                damage.applied_to(&mut bytes);
            }
            at_work.read(&bytes);
            Ok(())
        });
        result.unwrap_or_else(|fault| panic!("{}: {fault}", reader.name));
    }
}

/// Detects time or memory that grows quadratically with the file size, by repeating content of the file.
#[test]
fn files_grown_by_what_is_in_them_are_read_or_refused_in_a_moment() {
    const BYTES: usize = 300_000;
    for reader in &FILE_READERS {
        let at_work = ReaderAtWork::new(reader.name);
        for (name, bytes) in cases(reader) {
            // Three ranges of the file, aligned to lines if it has lines.
            for (share, length) in [(0.2, 40), (0.5, 7), (0.8, 200)] {
                #[allow(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a count that is not negative and small"
                )]
                let place = (share * bytes.len() as f64) as usize;
                let begin = bytes[..place].iter().rposition(|byte| *byte == b'\n').map_or(place, |at| at + 1);
                let stretch = &bytes[begin..(begin + length).min(bytes.len())];
                let grown = [&bytes[..begin], &stretch.repeat(BYTES / stretch.len().max(1)), &bytes[begin..]]
                    .concat();
                let start = std::time::Instant::now();
                at_work.read(&grown);
                assert!(
                    start.elapsed().as_secs() < 10,
                    "{}: {name} at {begin}: {:?}",
                    reader.name,
                    start.elapsed()
                );
            }
        }
    }
}

#[test]
fn each_reader_has_a_fuzz_target_and_each_target_a_reader() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut targets: Vec<String> = fs::read_dir(root.join("fuzz/targets"))
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    targets.sort();
    let mut names: Vec<&str> = FILE_READERS.iter().map(|reader| reader.name).collect();
    names.sort_unstable();
    assert_eq!(targets, names);
}
