//! Files of the checkout that are under version control, or will be.

use std::path::Path;
use std::process::Command;

/// File of the checkout.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceFile {
    /// Path from the root, with forward slashes.
    pub path: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl SourceFile {
    /// Returns the content if it is UTF-8.
    pub fn text(&self) -> Option<&str> {
        std::str::from_utf8(&self.bytes).ok()
    }

    /// Returns true if the name ends in `.extension`.
    pub fn has_extension(&self, extension: &str) -> bool {
        Path::new(&self.path).extension().is_some_and(|own| own == extension)
    }

    /// Creates a file for a test.
    #[cfg(test)]
    pub fn of_text(path: &str, text: &str) -> Self {
        Self { path: path.to_owned(), bytes: text.as_bytes().to_vec() }
    }
}

/// Returns all files below `root` that git tracks or would add, in the order of their paths.
///
/// Ignored files, such as build products and plans of experiments, are left out.
///
/// # Errors
/// If git is missing, `root` is no checkout, or a file cannot be read.
pub fn read_files(root: &Path) -> Result<Vec<SourceFile>, String> {
    let listing = answer(root, &["ls-files", "-z", "--cached", "--others", "--exclude-standard"])?;
    let mut paths: Vec<String> =
        listing.split('\0').filter(|path| !path.is_empty()).map(str::to_owned).collect();
    paths.sort();
    paths.dedup();
    paths
        .into_iter()
        // A deleted file stays listed until the deletion is staged.
        .filter(|path| root.join(path).is_file())
        .map(|path| match std::fs::read(root.join(&path)) {
            Ok(bytes) => Ok(SourceFile { path, bytes }),
            Err(error) => Err(format!("{path}: {error}")),
        })
        .collect()
}

/// Returns the files with changes that are not committed, and new files that are not ignored.
///
/// # Errors
/// If git is missing or `root` is no checkout.
pub fn changed_files(root: &Path) -> Result<Vec<String>, String> {
    let listing = answer(root, &["status", "--porcelain"])?;
    Ok(listing.lines().filter_map(|line| line.get(3..)).map(str::to_owned).collect())
}

/// Returns the time of the last commit, in seconds since 1970.
///
/// # Errors
/// As [`changed_files`].
pub fn commit_time(root: &Path) -> Result<String, String> {
    answer(root, &["log", "-1", "--format=%ct"]).map(|time| time.trim().to_owned())
}

/// Returns the output of git.
fn answer(root: &Path, words: &[&str]) -> Result<String, String> {
    let fault = |reason: &str| format!("`git {}` failed in {}: {reason}", words.join(" "), root.display());
    let output = git_in(root).args(words).output().map_err(|error| fault(&error.to_string()))?;
    if !output.status.success() {
        return Err(fault(String::from_utf8_lossy(&output.stderr).trim()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Returns git at `root`, independent of a repository that a surrounding hook may have set.
fn git_in(root: &Path) -> Command {
    let mut git = Command::new("git");
    git.current_dir(root);
    for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_PREFIX"] {
        git.env_remove(name);
    }
    git
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_without_git_is_an_error_that_names_it() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let message = read_files(folder.path()).expect_err("no checkout");
        assert!(message.contains(&folder.path().display().to_string()), "{message}");
    }

    #[test]
    fn new_files_are_seen_and_ignored_files_are_not() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let git = |words: &[&str]| git_in(folder.path()).args(words).output().expect("git");
        git(&["init", "--quiet"]);
        for (name, text) in [(".gitignore", "built/\n"), ("new.rs", "//! New.\n"), ("gone.rs", "")] {
            std::fs::write(folder.path().join(name), text).expect("write");
        }
        std::fs::create_dir(folder.path().join("built")).expect("folder");
        std::fs::write(folder.path().join("built/product"), "x").expect("write");
        git(&["add", "gone.rs"]);
        std::fs::remove_file(folder.path().join("gone.rs")).expect("remove");
        let changed = changed_files(folder.path()).expect("files");
        assert_eq!(changed, ["gone.rs", ".gitignore", "new.rs"]);

        let files = read_files(folder.path()).expect("files");
        let paths: Vec<&str> = files.iter().map(|file| file.path.as_str()).collect();
        assert_eq!(paths, [".gitignore", "new.rs"]);
        assert_eq!(files[1].text(), Some("//! New.\n"));
    }
}
