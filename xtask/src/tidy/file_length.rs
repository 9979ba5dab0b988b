//! Check of the length of Rust files.

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// Maximum number of lines: twice what a planner or a shape pair needs; longer files mix topics.
const MOST_LINES: usize = 500;

/// Reports Rust files of more than [`MOST_LINES`] lines.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    files
        .iter()
        .filter(|file| file.has_extension("rs"))
        .filter_map(|file| {
            let lines = file.text()?.lines().count();
            (lines > MOST_LINES).then(|| {
                Problem::new(
                    &file.path,
                    format!("{lines} lines, at most {MOST_LINES}"),
                    "find the second noun in it and give that a file of its own",
                )
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_past_the_last_allowed_one_fails() {
        let file = |path, lines| SourceFile::of_text(path, &"//\n".repeat(lines));
        assert_eq!(check(&[file("crates/plan/src/rrt.rs", MOST_LINES)]), []);
        assert_eq!(check(&[file("docs/long.md", MOST_LINES + 1)]), []);
        let problems = check(&[file("crates/plan/src/rrt.rs", MOST_LINES + 1)]);
        assert_eq!(problems.len(), 1);
        assert!(problems[0].message.contains("501"));
    }
}
