//! Check that links of pages lead to files of the checkout.

use std::path::Path;

use crate::checkout::SourceFile;
use crate::problem::Problem;
use crate::site::links;

/// Reports relative links of Markdown pages that name nothing in the checkout. Links that only the site has are written as
/// `<!-- site: [commands](commands.md) -->`.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let pages =
        files.iter().filter(|file| Path::new(&file.path).extension().is_some_and(|ending| ending == "md"));
    pages.flat_map(|page| broken(page, files)).collect()
}

fn broken(page: &SourceFile, files: &[SourceFile]) -> Vec<Problem> {
    let folder = Path::new(&page.path).parent().unwrap_or(Path::new(""));
    let is_there = |target: &Path| {
        let target = target.display().to_string();
        files.iter().any(|file| file.path == target || file.path.starts_with(&format!("{target}/")))
    };
    let text = links::for_the_repository(page.text().unwrap_or_default());
    let mut problems = Vec::new();
    links::rewritten(&text, |link| {
        let file = link.split(['#', ' ']).next().unwrap_or(link);
        if !links::joined(folder, file).is_some_and(|target| is_there(&target)) {
            let hint = "name a file of the checkout; what only the site has stands in `<!-- site: … -->`";
            problems.push(Problem::new(&page.path, format!("links to '{link}', which is not there"), hint));
        }
        None
    });
    problems
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_to_what_only_the_site_has_fails() {
        let problems = |text: &str| {
            let there = SourceFile::of_text("docs/files.md", "# Files\n");
            check(&[SourceFile::of_text("docs/index.md", text), there]).len()
        };
        assert_eq!(problems("[files](files.md#exit), [up](../docs), [web](https://example.org)"), 0);
        assert_eq!(problems("[commands](commands.md)"), 1);
        assert_eq!(problems("<!-- site: [commands](commands.md) -->"), 0);
        assert_eq!(problems("```md\n[commands](commands.md)\n```\n`[a](b)`"), 0);
    }
}
