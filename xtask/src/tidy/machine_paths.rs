//! Check that no file contains a path of one particular machine.

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// First folders of paths that exist on one machine only.
const PRIVATE: [&str; 5] = ["home", "Users", "root", "work", "mnt"];

/// Reports lines with an absolute path into a private folder.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let mut problems = Vec::new();
    for file in files {
        for (index, line) in file.text().unwrap_or_default().lines().enumerate() {
            if let Some(path) = private_path_in(line) {
                problems.push(Problem::new(
                    format!("{}:{}", file.path, index + 1),
                    format!("`{path}…` is a path of one machine"),
                    "write it relative to the checkout, or take it from an argument or from CRANNY_DATA",
                ));
            }
        }
    }
    problems
}

/// Returns the start of the first private path in `line`.
fn private_path_in(line: &str) -> Option<String> {
    PRIVATE.iter().find_map(|folder| {
        ['/', '\\'].into_iter().find_map(|separator| {
            let start = format!("{separator}{folder}{separator}");
            line.match_indices(&start)
                .any(|(at, _)| {
                    let before = line[..at].chars().next_back();
                    // `docs/home/` is relative and `example.org/home/` an address; `C:\…` has its colon.
                    let begins = !before.is_some_and(|c| c.is_alphanumeric() || "._-~)}>$".contains(c));
                    let continues = line[at + start.len()..].starts_with(|c: char| c.is_alphanumeric());
                    begins && continues
                })
                .then_some(start)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(line: &str) -> usize {
        check(&[SourceFile::of_text("README.md", &format!("# Title\n{line}\n"))]).len()
    }

    #[test]
    fn paths_of_one_machine_fail_wherever_they_begin() {
        for folder in PRIVATE {
            for line in [
                format!("/{folder}/ann/cranny"),
                format!("let path = \"/{folder}/ann\";"),
                format!("see [it](/{folder}/ann)"),
                format!("file:///{folder}/ann"),
                format!("C:\\{folder}\\ann"),
            ] {
                assert_eq!(found(&line), 1, "{line}");
            }
        }
    }

    #[test]
    fn the_line_is_named() {
        let line = format!("/{}/ann", PRIVATE[0]);
        let problems = check(&[SourceFile::of_text("README.md", &format!("# Title\n{line}\n"))]);
        assert_eq!(problems[0].place, "README.md:2");
    }

    #[test]
    fn relative_paths_addresses_and_shared_places_are_fine() {
        let folder = PRIVATE[0];
        for line in [
            format!("docs/{folder}/page.md"),
            format!("../{folder}/page.md"),
            format!("https://example.org/{folder}/page"),
            format!("`$PREFIX/{folder}/x`"),
            "/usr/share/fonts, /tmp/plan.json, ../shared/data".to_owned(),
        ] {
            assert_eq!(found(&line), 0, "{line}");
        }
    }
}
