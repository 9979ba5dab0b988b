//! Check that the name of a module is a noun of the field.

use std::path::Path;

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// Names that do not describe the content.
const DRAWERS: [&str; 7] = ["utils", "util", "common", "helpers", "helper", "misc", "types"];

/// Languages whose files are modules.
const LANGUAGES: [&str; 3] = ["rs", "py", "ts"];

/// Reports modules with one of the names [`DRAWERS`], or in a folder with one.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    files
        .iter()
        .filter(|file| LANGUAGES.iter().any(|language| file.has_extension(language)))
        .filter_map(|file| {
            let drawer = drawer_in(&file.path)?;
            Some(Problem::new(
                &file.path,
                format!("`{drawer}` is no name for a module"),
                "name the thing it holds: `shortcut.rs`, not `path_utils.rs`; \
                 a function without a home shows a missing noun",
            ))
        })
        .collect()
}

fn drawer_in(path: &str) -> Option<&'static str> {
    let stem = Path::new(path).with_extension("");
    DRAWERS.into_iter().find(|drawer| stem.iter().any(|part| part.eq_ignore_ascii_case(drawer)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_drawer_fails_as_file_and_as_folder() {
        for drawer in DRAWERS {
            for path in [
                format!("crates/plan/src/{drawer}.rs"),
                format!("crates/plan/tests/{drawer}/mod.rs"),
                format!("xtask/src/{drawer}/walk.rs"),
                format!("python/cranny/{drawer}.py"),
                format!("web/src/{drawer}.ts"),
            ] {
                let problems = check(&[SourceFile::of_text(&path, "")]);
                assert_eq!(problems.len(), 1, "{path}");
                assert_eq!(problems[0].place, path);
            }
        }
    }

    #[test]
    fn nouns_are_fine_and_so_are_files_that_are_no_modules() {
        let paths = ["crates/plan/src/shortcut.rs", "crates/robot/src/joint_types.rs", "docs/common.md"];
        assert_eq!(check(&paths.map(|path| SourceFile::of_text(path, ""))), []);
    }
}
