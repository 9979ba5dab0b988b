//! Check of the number of files in a source folder.

use std::collections::BTreeMap;

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// Maximum number of files of a source folder.
const MOST_FILES: usize = 20;

/// Reports source folders of more than [`MOST_FILES`] files of Rust or TypeScript.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for file in files.iter().filter(|file| file.has_extension("rs") || file.has_extension("ts")) {
        let folder = file.path.rsplit_once('/').map_or("", |(folder, _)| folder);
        if folder.split('/').any(|name| name == "src") {
            *counts.entry(folder).or_default() += 1;
        }
    }
    let too_many = counts.into_iter().filter(|(_, count)| *count > MOST_FILES);
    too_many
        .map(|(folder, count)| {
            let message = format!("{count} files, at most {MOST_FILES}");
            Problem::new(folder, message, "find the questions in it and give each a folder")
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_past_the_last_allowed_one_fails() {
        let files = |folder: &str, count: usize| -> Vec<SourceFile> {
            (0..count).map(|file| SourceFile::of_text(&format!("{folder}/{file}.rs"), "//\n")).collect()
        };
        assert_eq!(check(&files("crates/plan/src", MOST_FILES)), []);
        assert_eq!(check(&files("crates/plan/tests", MOST_FILES + 1)), []);
        let problems = check(&files("crates/plan/src/task", MOST_FILES + 1));
        assert_eq!(problems.len(), 1);
        assert!(problems[0].message.contains("21"));
    }
}
