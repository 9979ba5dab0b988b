//! Check that code specific to an operating system is in one module, beside its alternatives.

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// Module that may name a system.
const ADDRESS: &str = "crates/file/src/system";

/// Conditions that name one, each in two pieces, so that this file does not match itself.
const NAMES: [&str; 9] = [
    concat!("cfg(", "unix"),
    concat!("cfg(", "windows"),
    concat!("cfg(not(", "unix"),
    concat!("cfg(not(", "windows"),
    concat!("target", "_os"),
    concat!("target", "_family"),
    concat!("std::os", "::"),
    concat!("signal::", "unix"),
    concat!("rust", "ix::"),
];

/// Process file system, which exists on Linux only.
const PROC: &str = concat!("\"/pro", "c/");

/// Reports sources of crates and of the Python package that call the operating system themselves; tests may.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let is_source = |file: &&SourceFile| {
        let mut parts = file.path.split('/');
        let is_of_room = match parts.next() {
            Some("crates") => parts.nth(1) == Some("src"),
            Some("python") => parts.next() == Some("src"),
            _ => false,
        };
        is_of_room && file.has_extension("rs") && !file.path.starts_with(ADDRESS)
    };
    let named = files.iter().filter(is_source).filter_map(|file| Some((file, naming_line(file.text()?)?)));
    named
        .map(|(file, line)| {
            Problem::new(
                &file.path,
                format!("asks one operating system by itself in line {line}"),
                format!("ask it in `{ADDRESS}`, which says what holds on the others"),
            )
        })
        .collect()
}

/// Returns the first line before the tests that names a system, from 1.
fn naming_line(text: &str) -> Option<usize> {
    let is_of_tests = |line: &str| line.starts_with("#[cfg(") && line.contains("test");
    let lines: Vec<&str> = text.lines().take_while(|line| !is_of_tests(line)).collect();
    let names = |line: &&str| NAMES.iter().any(|name| line.contains(name)) || line.contains(PROC);
    lines.iter().position(names).map(|index| index + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_that_is_named_elsewhere_fails() {
        for name in NAMES.into_iter().chain([PROC]) {
            let text = format!("//! Robots.\nlet text = {name}();\n");
            let file = |path| [SourceFile::of_text(path, &text)];
            assert_eq!(check(&file("crates/view/src/viewer/page.rs")).len(), 1, "{name}");
            assert_eq!(check(&file("python/src/page.rs")).len(), 1, "{name}");
            assert_eq!(check(&file("crates/file/src/system/process.rs")), [], "{name}");
            assert_eq!(check(&file("crates/view/tests/page.rs")), [], "{name}");
        }
    }

    #[test]
    fn tests_may_name_one() {
        let text = format!("fn a() {{}}\n#[cfg(all(test, x))]\nmod tests {{ {} }}\n", NAMES[0]);
        assert_eq!(check(&[SourceFile::of_text("crates/view/src/viewer/page.rs", &text)]), []);
    }
}
