//! Licences of the components of the program, the Python package and the page, which every copy must include.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use cargo_metadata::Package;
use cargo_metadata::camino::Utf8Path;

use crate::checkout::SourceFile;
use crate::contents::Contents;
use crate::problem::Problem;

/// Page of the licences, which `cranny licences` prints, relative to the root.
pub const PAGE: &str = "crates/view/NOTICES.txt";

const THREE_JS: &str = "Copyright © 2010-2026 three.js authors";

const RULE: &str = "================================================================================";

/// Reports a page that differs from the licences of the packages.
///
/// # Errors
/// As [`text`].
pub fn check(root: &Path, files: &[SourceFile]) -> Result<Vec<Problem>, String> {
    let written = files.iter().find(|file| file.path == PAGE).and_then(SourceFile::text);
    if written == Some(text(root)?.as_str()) {
        return Ok(Vec::new());
    }
    Ok(vec![Problem::new(
        PAGE,
        "differs from the licences of the packages",
        "run `cargo xtask tidy --write`",
    )])
}

/// Writes the page if it differs.
///
/// # Errors
/// As [`text`], and if the page cannot be written.
pub fn write(root: &Path) -> Result<(), String> {
    let text = text(root)?;
    let path = root.join(PAGE);
    if std::fs::read_to_string(&path).is_ok_and(|written| written == text) {
        return Ok(());
    }
    println!("tidy: wrote {PAGE}");
    std::fs::write(&path, text).map_err(|error| format!("{PAGE}: {error}"))
}

/// Returns the page: the own licences, three.js, then every licence with the packages that are under it.
///
/// # Errors
/// If cargo does not know the packages, or a file of theirs cannot be read.
fn text(root: &Path) -> Result<String, String> {
    let contents = Contents::of(root)?;
    let mut of_text: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in contents.packages() {
        let expression = package.license.as_deref().unwrap_or("a licence of its own");
        let name = format!("{} {} ({expression})", package.name, package.version);
        for licence in licences(package)? {
            of_text.entry(licence).or_default().push(name.clone());
        }
    }
    let mut grouped: Vec<(Vec<String>, String)> =
        of_text.into_iter().map(|(licence, names)| (names, licence)).collect();
    grouped.sort();

    let own =
        |name: &str| std::fs::read_to_string(root.join(name)).map_err(|error| format!("{name}: {error}"));
    let mut page = String::from(
        "Cranny is licensed as MIT or Apache-2.0, as you prefer; both stand first. What follows are the licences of\n\
         what its programs, its Python package and the viewer's page are made of.\n",
    );
    let mut add = |title: &str, licence: &str| {
        let _ = write!(page, "\n{RULE}\n{title}\n{RULE}\n\n{}\n", licence.trim_end());
    };
    add("Cranny (MIT)", &own("LICENSE-MIT")?);
    add("Cranny (Apache-2.0)", &own("LICENSE-APACHE")?);
    add(&format!("three.js {} (MIT)", contents.three_js), &mit(THREE_JS));
    for (names, licence) in grouped {
        add(&names.join("\n"), &licence);
    }
    Ok(page)
}

/// Returns the licences under which a package is used: MIT if the package offers it, else all of its licences.
fn licences(package: &Package) -> Result<Vec<String>, String> {
    let Some(folder) = package.manifest_path.parent() else { return Ok(Vec::new()) };
    let mut licences = own_licences(package, folder)?;
    for entry in folder.join("assets").read_dir().into_iter().flatten().flatten() {
        if let Ok(licence) = std::fs::read(entry.path().join("LICENSE")) {
            licences.push(trimmed(&licence));
        }
    }
    Ok(licences)
}

fn own_licences(package: &Package, folder: &Utf8Path) -> Result<Vec<String>, String> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|error| format!("{folder}: {error}"))? {
        let name =
            entry.map_err(|error| format!("{folder}: {error}"))?.file_name().to_string_lossy().into_owned();
        let capital = name.to_uppercase();
        let is_licence = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"]
            .iter()
            .any(|beginning| capital.starts_with(beginning));
        if is_licence && folder.join(&name).is_file() {
            files.push((capital, name));
        }
    }
    files.sort();
    let expression = package.license.as_deref().unwrap_or_default();
    let is_choice = [" OR ", "/"].iter().any(|or| expression.contains(or));
    if is_choice && files.iter().any(|(capital, _)| capital.contains("MIT")) {
        files.retain(|(capital, _)| capital.contains("MIT") || capital.starts_with("NOTICE"));
    }
    if files.is_empty() {
        let authors = package.authors.iter().map(|author| author.split(" <").next().unwrap_or(author));
        let authors = authors.collect::<Vec<_>>().join(", ");
        let holder = if authors.is_empty() { format!("the authors of {}", package.name) } else { authors };
        return match expression {
            expression if expression.contains("MIT") => Ok(vec![mit(&format!("Copyright © {holder}"))]),
            // The text of the project's own copy is above.
            expression if expression.contains("Apache-2.0") => {
                Ok(vec![format!("Copyright © {holder}\n\nApache-2.0, as above.")])
            }
            other => Err(format!("{} {}: no file with its licence ({other})", package.name, package.version)),
        };
    }
    let read = |(_, name): &(String, String)| {
        let bytes = std::fs::read(folder.join(name)).map_err(|error| format!("{folder}/{name}: {error}"))?;
        Ok(trimmed(&bytes))
    };
    files.iter().map(read).collect()
}

/// Returns a text without blanks at the ends of its lines and without blank lines at its ends.
fn trimmed(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let lines: Vec<&str> = text.trim_start_matches('\u{feff}').lines().map(str::trim_end).collect();
    lines.join("\n").trim_matches('\n').to_owned()
}

fn mit(copyright: &str) -> String {
    format!(
        "The MIT License

{copyright}

Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
documentation files (the \"Software\"), to deal in the Software without restriction, including without limitation the
rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit
persons to whom the Software is furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in all copies or substantial portions of the
Software.

THE SOFTWARE IS PROVIDED \"AS IS\", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR
COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR
OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE."
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_is_old_or_missing_is_a_problem() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let right = text(&root).expect("the licences of the packages");
        assert!(right.contains("\nclap ") && right.contains("three.js") && right.contains("pyo3"));
        assert!(right.contains("Bitstream Vera Fonts Copyright"), "the font of the charts");
        assert!(!right.contains("proptest"), "what tests are built with is not given away");
        assert_eq!(check(&root, &[SourceFile::of_text(PAGE, &right)]), Ok(Vec::new()));
        let old = right.replace("\nclap ", "\nclop ");
        for files in [vec![], vec![SourceFile::of_text(PAGE, &old)]] {
            assert_eq!(check(&root, &files).map(|problems| problems.len()), Ok(1));
        }
    }
}
