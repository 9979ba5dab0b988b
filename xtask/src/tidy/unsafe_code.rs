//! Check that `unsafe` code is confined to two folders.
//!
//! The workspace denies the lint, so the compiler does most of the work; this check prevents exceptions.

use crate::checkout::SourceFile;
use crate::member::Member;
use crate::problem::Problem;

/// Folders that may allow it: for lanes, and for the pointers of C.
const ADDRESSES: [&str; 2] = ["crates/spatial/", "crates/capi/"];
/// Name of the lint, in two pieces, so that this file does not match itself.
const LINT: &str = concat!("unsafe", "_code");
/// Attributes that lower a denied lint.
const LOWERING: [&str; 3] = ["allow(", "expect(", "warn("];

/// Reports files that lower the lint elsewhere, and crates that do not inherit the lints of the workspace.
pub fn check(members: &[Member], files: &[SourceFile]) -> Vec<Problem> {
    let lowered = files
        .iter()
        .filter(|file| {
            file.has_extension("rs") && !ADDRESSES.iter().any(|address| file.path.starts_with(address))
        })
        .filter(|file| file.text().is_some_and(lowers_lint))
        .map(|file| {
            Problem::new(
                &file.path,
                format!("lowers the lint `{LINT}`"),
                format!("write it in safe code, or put it where it belongs: {}", ADDRESSES.join(", ")),
            )
        });
    let uninherited = members.iter().filter_map(|member| {
        let manifest = files.iter().find(|file| file.path == member.manifest())?;
        (!inherits_lints(manifest.text()?)).then(|| {
            Problem::new(
                &manifest.path,
                "does not inherit the lints of the workspace",
                "add `[lints]` with `workspace = true`",
            )
        })
    });
    lowered.chain(uninherited).collect()
}

/// Returns true if an attribute of `text` lowers the lint, on any number of lines.
fn lowers_lint(text: &str) -> bool {
    let dense: String = text.split_whitespace().collect();
    LOWERING.iter().any(|attribute| {
        dense.match_indices(attribute).any(|(at, _)| {
            let inside = dense[at + attribute.len()..].split(')').next().unwrap_or_default();
            inside.split(',').any(|lint| lint == LINT)
        })
    })
}

fn inherits_lints(manifest: &str) -> bool {
    manifest
        .lines()
        .map(str::trim)
        .skip_while(|line| *line != "[lints]")
        .skip(1)
        .take_while(|line| !line.starts_with('['))
        .any(|line| line.replace(' ', "") == "workspace=true")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_of_lowering_the_lint_fails_outside_its_address() {
        for attribute in [
            format!("#![allow({LINT})]"),
            format!("#[expect({LINT}, reason = \"lanes\")]"),
            format!("#[allow(\n    missing_docs,\n    {LINT},\n)]"),
            format!("#![cfg_attr(test, warn({LINT}))]"),
        ] {
            let file =
                |path: &str| [SourceFile::of_text(path, &format!("//! Lanes.\n{attribute}\nmod lane;\n"))];
            assert_eq!(check(&[], &file("crates/collision/src/lib.rs")).len(), 1, "{attribute}");
            for address in ADDRESSES {
                assert_eq!(check(&[], &file(&format!("{address}src/lib.rs"))), [], "{attribute}");
            }
        }
    }

    #[test]
    fn denying_it_and_allowing_other_lints_is_fine() {
        let text = format!("#![deny({LINT})]\n#[allow(missing_docs)]\nmod lane;\n");
        assert_eq!(check(&[], &[SourceFile::of_text("crates/plan/src/lib.rs", &text)]), []);
    }

    #[test]
    fn a_crate_with_lints_of_its_own_fails() {
        let member = [Member { folder: "crates/plan".to_owned(), ..Member::default() }];
        let manifest = |text| [SourceFile::of_text("crates/plan/Cargo.toml", text)];
        assert_eq!(check(&member, &manifest("[package]\n\n[lints]\nworkspace = true\n")), []);
        for text in
            ["[package]\n", "[lints.rust]\nmissing_docs = \"warn\"\n", "[lints]\n[x]\nworkspace = true\n"]
        {
            assert_eq!(check(&member, &manifest(text)).len(), 1, "{text}");
        }
    }
}
