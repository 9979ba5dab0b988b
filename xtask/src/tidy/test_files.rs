//! Check that every test file is a module of its crate's test program, or a program of the manifest; other files never run.

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// Reports files directly below a crate's `tests/` that `tests/main.rs` does not name, and programs in folders there that
/// `Cargo.toml` does not name.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let names = |path: &str, line: &str| {
        let text = files.iter().find(|file| file.path == path).and_then(SourceFile::text);
        text.is_some_and(|text| text.lines().any(|other| other.trim() == line))
    };
    files
        .iter()
        .filter_map(|file| {
            let (member, in_tests) = file.path.split_once("/tests/")?;
            let (path, line) = match in_tests.strip_suffix(".rs")?.split_once('/') {
                None if in_tests == "main.rs" => return None,
                None => {
                    (format!("{member}/tests/main.rs"), format!("mod {};", in_tests.trim_end_matches(".rs")))
                }
                Some((_, "main")) => (format!("{member}/Cargo.toml"), format!("path = \"tests/{in_tests}\"")),
                Some(_) => return None,
            };
            (!names(&path, &line)).then(|| {
                Problem::new(
                    &file.path,
                    "these tests never run".to_owned(),
                    format!("add `{line}` to {path}"),
                )
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_the_program_does_not_name_is_found() {
        let main = SourceFile::of_text("crates/plan/tests/main.rs", "mod fixture;\n\nmod twins;\n");
        let named = SourceFile::of_text("crates/plan/tests/twins.rs", "");
        let helper = SourceFile::of_text("crates/plan/tests/fixture/mod.rs", "");
        let manifest =
            SourceFile::of_text("crates/plan/Cargo.toml", "[[test]]\npath = \"tests/oracle/main.rs\"\n");
        let program = SourceFile::of_text("crates/plan/tests/oracle/main.rs", "");
        assert_eq!(check(&[main, named, helper, manifest, program]), []);

        let main = SourceFile::of_text("crates/plan/tests/main.rs", "// mod audit;\nmod twins;\n");
        let forgotten = SourceFile::of_text("crates/plan/tests/audit.rs", "");
        let elsewhere = SourceFile::of_text("crates/robot/tests/audit.rs", "");
        let program = SourceFile::of_text("crates/robot/tests/oracle/main.rs", "");
        let found: Vec<String> =
            check(&[main, forgotten, elsewhere, program]).into_iter().map(|problem| problem.place).collect();
        assert_eq!(
            found,
            [
                "crates/plan/tests/audit.rs",
                "crates/robot/tests/audit.rs",
                "crates/robot/tests/oracle/main.rs"
            ]
        );
    }
}
