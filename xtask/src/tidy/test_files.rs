//! Every file of tests is a module of its crate's one test program: a file that nobody names never runs.

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// Files right below a crate's `tests/` which its `tests/main.rs` does not name.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let in_tests = |file: &SourceFile| {
        let (tests, name) = file.path.rsplit_once('/')?;
        (tests.ends_with("/tests") && file.has_extension("rs")).then(|| (tests.to_owned(), name.to_owned()))
    };
    files
        .iter()
        .filter_map(|file| Some((file, in_tests(file)?)))
        .filter(|(_, (tests, name))| {
            let main = files.iter().find(|other| other.path == format!("{tests}/main.rs"));
            let module = format!("mod {};", name.trim_end_matches(".rs"));
            name != "main.rs"
                && !main
                    .and_then(SourceFile::text)
                    .is_some_and(|text| text.lines().any(|line| line.trim() == module))
        })
        .map(|(file, (tests, name))| {
            Problem::new(
                &file.path,
                "these tests never run".to_owned(),
                format!("add `mod {};` to {tests}/main.rs", name.trim_end_matches(".rs")),
            )
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
        assert_eq!(check(&[main, named, helper]), []);

        let main = SourceFile::of_text("crates/plan/tests/main.rs", "// mod audit;\nmod twins;\n");
        let forgotten = SourceFile::of_text("crates/plan/tests/audit.rs", "");
        let elsewhere = SourceFile::of_text("crates/robot/tests/audit.rs", "");
        let found: Vec<String> =
            check(&[main, forgotten, elsewhere]).into_iter().map(|problem| problem.place).collect();
        assert_eq!(found, ["crates/plan/tests/audit.rs", "crates/robot/tests/audit.rs"]);
    }
}
