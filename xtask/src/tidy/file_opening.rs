//! Check that files are opened in one crate, which enforces the limits.

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// Folder that may open files, and files that open others than inputs: the marks and lists of unfinished output, the locks of
/// campaigns, and results, which `SQLite` opens.
const ADDRESSES: [&str; 6] = [
    "crates/file/",
    "crates/scenario/src/files/staging_folder.rs",
    "crates/scenario/src/family/unfinished_set.rs",
    "crates/bench/src/store/exports.rs",
    "crates/bench/src/store/results.rs",
    "crates/bench/src/store/results_file.rs",
];

/// Calls that open a file for reading, each in two pieces, so that this file does not match itself.
const OPENERS: [&str; 5] = [
    concat!("fs::", "read("),
    concat!("fs::", "read_to_string("),
    concat!("File::", "open("),
    concat!("File::", "options("),
    concat!("OpenOptions::", "new("),
];

/// Reports sources of crates that open files themselves; tests may.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let is_source = |file: &&SourceFile| {
        let folders: Vec<&str> = file.path.split('/').collect();
        let is_of_crate = matches!(folders[..], ["crates", _, "src", ..] | ["python", "src", ..]);
        let is_allowed = ADDRESSES.iter().any(|address| file.path.starts_with(address));
        is_of_crate && file.has_extension("rs") && !is_allowed
    };
    let opened = files.iter().filter(is_source).filter_map(|file| Some((file, opening_line(file.text()?)?)));
    opened
        .map(|(file, line)| {
            Problem::new(
                &file.path,
                format!("opens a file by itself in line {line}"),
                "read it with `cranny_file`, which refuses pipes, devices and what is too large",
            )
        })
        .collect()
}

/// Returns the first line before the tests that opens a file for reading, from 1.
fn opening_line(text: &str) -> Option<usize> {
    let is_of_tests = |line: &&str| line.starts_with("#[cfg(") && line.contains("test");
    let lines = text.lines().take_while(|line| !is_of_tests(line));
    let opens = |line: &str| OPENERS.iter().any(|opener| line.contains(opener));
    lines.enumerate().find(|(_, line)| opens(line)).map(|(index, _)| index + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_of_its_own_fails_outside_the_room_for_it() {
        for opener in OPENERS {
            let text = format!("//! Robots.\nlet text = {opener}path)?;\n");
            let file = |path| [SourceFile::of_text(path, &text)];
            assert_eq!(check(&file("crates/robot/src/description/urdf.rs")).len(), 1, "{opener}");
            assert_eq!(check(&file("python/src/robot.rs")).len(), 1, "{opener}");
            assert_eq!(check(&file("crates/file/src/opener.rs")), [], "{opener}");
            assert_eq!(check(&file("crates/robot/tests/urdf.rs")), [], "{opener}");
        }
    }

    #[test]
    fn tests_are_fine() {
        let [read, ..] = OPENERS;
        let text = format!("let a = 1;\n#[cfg(test)]\nmod tests {{ {read}path); }}\n");
        assert_eq!(check(&[SourceFile::of_text("crates/bench/src/a.rs", &text)]), []);
    }
}
