//! Check that the items in the walks of ARCHITECTURE exist in the files that it names.

use crate::checkout::SourceFile;
use crate::problem::Problem;

const PAGE: &str = "ARCHITECTURE.md";

/// Heading of the walks on the page; they end at the next heading.
const HEADING: &str = "\n## From input to result\n";

/// Checks that every ``[`item`](file)`` of the walks names a file of the checkout, and an item declared in it.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let Some(page) = files.iter().find(|file| file.path == PAGE).and_then(SourceFile::text) else {
        return Vec::new();
    };
    let Some((_, walks)) = page.split_once(HEADING) else {
        return vec![Problem::new(
            PAGE,
            "has no walks",
            "describe the data flow under `## From input to result`",
        )];
    };
    let walks = walks.split("\n## ").next().unwrap_or(walks);
    let missing = links(walks).filter(|(item, path)| {
        let text = files.iter().find(|file| file.path == *path).and_then(SourceFile::text);
        !text.is_some_and(|text| declares(text, item))
    });
    missing
        .map(|(item, path)| {
            Problem::new(PAGE, format!("says that '{item}' is in {path}"), "name the file that declares it")
        })
        .collect()
}

/// Returns the items and the files of a text.
fn links(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.split("[`").skip(1).filter_map(|rest| {
        let (item, rest) = rest.split_once("`](")?;
        Some((item, rest.split_once(')')?.0))
    })
}

/// Returns true if a source declares the last name of a path such as `Cell::is_free`.
fn declares(text: &str, item: &str) -> bool {
    let name = item.rsplit("::").next().unwrap_or(item);
    ["fn", "struct", "enum", "trait"].iter().any(|kind| {
        let declaration = format!("{kind} {name}");
        text.match_indices(&declaration).any(|(at, _)| {
            !text[at + declaration.len()..].starts_with(|next: char| next.is_alphanumeric() || next == '_')
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problems(walk: &str) -> Vec<Problem> {
        let page =
            format!("# A\n\n## From input to result\n\n{walk}\n\n## Next\n\n[`nothing`](nowhere.rs)\n");
        let source = SourceFile::of_text("crates/a/src/a.rs", "pub fn open_all() {}\npub struct Open {}\n");
        check(&[SourceFile::of_text(PAGE, &page), source])
    }

    #[test]
    fn a_walk_past_what_is_not_there_fails() {
        assert_eq!(problems("[`Open`](crates/a/src/a.rs), then [`A::open_all`](crates/a/src/a.rs)."), []);
        assert_eq!(problems("[`open`](crates/a/src/a.rs)").len(), 1);
        assert_eq!(problems("[`Open`](crates/a/src/b.rs)").len(), 1);
    }

    #[test]
    fn a_page_without_walks_fails() {
        assert_eq!(check(&[SourceFile::of_text(PAGE, "# A\n")]).len(), 1);
    }
}
