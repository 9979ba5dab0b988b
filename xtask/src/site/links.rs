//! Links of pages, before and after the build.

use std::fs;
use std::path::{Component, Path, PathBuf};

/// Returns a Markdown page with each link replaced for which `new` returns a target.
pub fn rewritten(page: &str, mut new: impl FnMut(&str) -> Option<String>) -> String {
    let mut text = String::with_capacity(page.len());
    let mut rest = page;
    while let Some((before, after)) = rest.split_once("](") {
        let Some((link, after)) = after.split_once(')') else { break };
        text.push_str(before);
        let place = Some(link).filter(|link| !is_elsewhere(link)).and_then(&mut new);
        text.extend(["](", place.as_deref().unwrap_or(link), ")"]);
        rest = after;
    }
    text + rest
}

/// Returns a page for the site, with `<!-- site: TEXT -->` as text and without `<!-- repository -->TEXT<!-- end -->`.
pub fn for_the_site(page: &str) -> String {
    let replaced = |page: &str, begin: &str, end: &str, is_kept: bool| {
        let mut text = String::with_capacity(page.len());
        let mut rest = page;
        while let Some((before, (inner, after))) =
            rest.split_once(begin).and_then(|(before, after)| Some((before, after.split_once(end)?)))
        {
            text.push_str(before);
            text.push_str(if is_kept { inner } else { "" });
            rest = after;
        }
        text + rest
    };
    replaced(&replaced(page, "<!-- site: ", " -->", true), "<!-- repository -->", "<!-- end -->", false)
}

/// Returns a page without comments and code, with the links that a reader of the repository can follow.
pub fn for_the_repository(page: &str) -> String {
    let without = |page: &str, mark: &str, end: &str| {
        let mut text = String::new();
        let mut rest = page;
        while let Some((before, after)) = rest.split_once(mark) {
            text.push_str(before);
            rest = after.split_once(end).map_or("", |(_, after)| after);
        }
        text + rest
    };
    without(&without(&without(page, "<!--", "-->"), "```", "```"), "`", "`")
}

/// Joins a relative link to a folder and resolves `..`; `None` if it leads out of the root.
pub fn joined(folder: &Path, link: &str) -> Option<PathBuf> {
    let mut path = folder.to_owned();
    for component in Path::new(link).components() {
        match component {
            Component::ParentDir => {
                path.pop().then_some(())?;
            }
            Component::Normal(name) => path.push(name),
            _ => {}
        }
    }
    Some(path)
}

fn is_elsewhere(link: &str) -> bool {
    link.contains("://") || link.starts_with(['#', '<']) || link.starts_with("mailto:") || link.is_empty()
}

/// Checks every link of a built book and returns the number of its pages.
///
/// # Errors
/// List of broken links, and of external resources that a page would load.
pub fn check(book: &Path) -> Result<usize, String> {
    let mut faults = Vec::new();
    let mut count = 0;
    for folder in ["", "docs", "docs/decisions", "benchmarks"] {
        let folder = book.join(folder);
        for entry in fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))? {
            let path = entry.map_err(|error| error.to_string())?.path();
            // Reports and live pages are self-contained.
            if path.extension().is_some_and(|ending| ending == "html") {
                let page =
                    fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
                if page.contains("<!-- Book generated using mdBook -->") {
                    count += 1;
                    faults.extend(
                        faults_of(&page, &folder).map(|fault| format!("{}: {fault}", path.display())),
                    );
                }
            }
        }
    }
    if faults.is_empty() { Ok(count) } else { Err(faults.join("\n")) }
}

/// Returns the errors in the links of a page.
fn faults_of<'a>(page: &'a str, folder: &'a Path) -> impl Iterator<Item = String> + 'a {
    let named = ["href=\"", "src=\""].into_iter().flat_map(move |key| {
        page.match_indices(key).filter_map(move |(at, _)| {
            let link = page[at + key.len()..].split('"').next()?;
            let is_loaded = key == "src=\"" || page[..at].rsplit('<').next()?.starts_with("link");
            Some((link, is_loaded))
        })
    });
    named.filter_map(move |(link, is_loaded)| {
        if is_elsewhere(link) || link.starts_with("data:") {
            return (is_loaded && link.contains("://")).then(|| format!("loads {link}"));
        }
        let target = folder.join(link.split(['#', '?']).next()?);
        (!target.exists()).then(|| format!("{link} leads nowhere"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_replaced_where_there_is_a_new_place() {
        let page = "[a](b.md), [c](https://d), ![e](f.png) and [g](#h) (i)";
        let new = |link: &str| (link == "b.md").then(|| "x/b.md".to_owned());
        assert_eq!(rewritten(page, new), "[a](x/b.md), [c](https://d), ![e](f.png) and [g](#h) (i)");
    }

    #[test]
    fn paths_are_joined_without_steps_back() {
        assert_eq!(joined(Path::new("docs"), "../benchmarks/a.md"), Some("benchmarks/a.md".into()));
        assert_eq!(joined(Path::new("docs"), "./schema/b.json"), Some("docs/schema/b.json".into()));
        assert_eq!(joined(Path::new("docs"), "../../c"), None);
    }

    #[test]
    fn a_link_that_leads_nowhere_and_a_file_from_elsewhere_are_faults() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("there.html"), "").expect("written");
        let page = r##"<a href="there.html#x"><a href="#y"><a href="https://z"><script src="https://cdn"></script>
            <link rel="stylesheet" href="https://fonts"><img src="gone.png">"##;
        let faults: Vec<String> = faults_of(page, folder.path()).collect();
        assert_eq!(faults, ["loads https://fonts", "loads https://cdn", "gone.png leads nowhere"]);
    }
}
