//! `NumPy` archives and arrays with more content, or other content, than is read.

use std::io::{Cursor, Write as _};

use cranny_grasp::ImportSettings;

use crate::imports::{Files, QUARTER, npy, npz};

fn archive(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        archive.start_file(*name, zip::write::SimpleFileOptions::default()).expect("an entry");
        archive.write_all(bytes).expect("bytes");
    }
    archive.finish().expect("an archive").into_inner()
}

/// The library returns the last of two entries of one name.
#[test]
fn an_archive_that_holds_a_name_twice_is_refused() {
    let poses = npy(&[1, 4, 4], &QUARTER);
    let mut bytes = archive(&[("poses.npy", &poses), ("posez.npy", &poses)]);
    let places: Vec<usize> =
        (0..bytes.len()).filter(|place| bytes[*place..].starts_with(b"posez.npy")).collect();
    assert_eq!(places.len(), 2, "in the entry and in the directory");
    for place in places {
        bytes[place + 4] = b's';
    }
    let fault = Files::new().read(&bytes, &ImportSettings::default()).expect_err("two poses");
    assert!(fault.contains("holds 'poses.npy' twice"), "{fault}");
}

#[test]
fn entries_of_an_archive_that_are_no_array_of_a_known_name_are_noted() {
    let poses = npy(&[1, 4, 4], &QUARTER);
    let bytes = archive(&[("readme", b"in mm"), ("poses.npy", &poses), ("valid.npy", &poses)]);
    let read = Files::new().read(&bytes, &ImportSettings::default()).expect("grasps");
    assert!(read.notes.iter().any(|note| note == "not read: valid, readme"), "{:?}", read.notes);
}

#[test]
fn an_array_or_archive_that_ends_early_or_goes_on_is_refused() {
    let files = Files::new();
    let poses = npy(&[1, 4, 4], &QUARTER);
    let longer = [&poses[..], b"xxxx"].concat();
    let whole = npz(&[("poses", poses.clone())]);
    for (bytes, words) in [
        (poses[..poses.len() - 9].to_vec(), "the array ends before the last number of its shape [1, 4, 4]"),
        (longer.clone(), "the array goes on after the numbers of its shape [1, 4, 4]"),
        (archive(&[("poses.npy", &longer)]), "poses goes on after the numbers"),
        ([&whole[..], b"xxxx"].concat(), "the archive: something stands before or after it"),
    ] {
        let fault = files.read(&bytes, &ImportSettings::default()).expect_err(words);
        assert!(fault.contains(words), "no '{words}' in: {fault}");
    }
}

#[test]
fn columns_of_an_archive_that_are_none_are_refused() {
    let files = Files::new();
    let with = |name: &'static str, value: f64| {
        npz(&[("poses", npy(&[1, 4, 4], &QUARTER)), (name, npy(&[1], &[value]))])
    };
    for (bytes, words) in [
        (with("widths", 5.0), "the width of grasp 0 is 5 m"),
        (with("widths", 5.0), "are these centimetres or millimetres?"),
        (with("mask", 0.5), "mask holds 0.5, which is neither true nor false"),
        (with("mask", f64::NAN), "mask holds NaN"),
        (with("masks", 1.0), "it holds 'masks', which is no array that is read; did you mean 'mask'?"),
        (with("score", 1.0), "did you mean 'scores'?"),
    ] {
        let fault = files.read(&bytes, &ImportSettings::default()).expect_err(words);
        assert!(fault.contains(words), "no '{words}' in: {fault}");
    }
    assert!(files.read(&with("widths", 0.05), &ImportSettings::default()).is_ok());
}

/// Guards against exponential time: 3000 brackets took over 30 s.
#[test]
fn brackets_in_a_header_are_counted() {
    let shape = ["[".repeat(30_000), "]".repeat(30_000)].concat();
    let head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}");
    let size = u16::try_from(head.len()).expect("short").to_le_bytes();
    let array = [&b"\x93NUMPY\x01\x00"[..], &size, head.as_bytes()].concat();
    for bytes in [array.clone(), npz(&[("poses", array)])] {
        let fault = Files::new().read(&bytes, &ImportSettings::default()).expect_err("no shape");
        assert!(fault.contains("'shape' is [[[") && fault.contains("not a list of lengths"), "{fault}");
    }
}
