//! Location of the paper's released data, and whether a run may do without them.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Environment variable that names the data folder.
pub const DATA: &str = "CRANNY_DATA";
/// Environment variable that forbids skipping.
pub const REQUIRE_ALL: &str = "CRANNY_REQUIRE_ALL";
/// Message of a run without data.
pub const SKIPPED: &str = "SKIPPED: tests on released data (set CRANNY_DATA)";

/// Folder that the data folder must contain.
const RELEASE: &str = "jogramop";

/// Returns the data folder as an absolute path, `None` if `CRANNY_DATA` is unset or empty.
///
/// # Errors
/// If the variable names something that is not the data folder, or is unset although nothing may be skipped.
pub fn folder() -> Result<Option<PathBuf>, String> {
    let current = env::current_dir().map_err(|error| format!("the current folder: {error}"))?;
    match folder_of(env::var_os(DATA), &current)? {
        None if all_required() => {
            Err(format!("{REQUIRE_ALL} is set, but {DATA} is not: name the folder of the released data"))
        }
        folder => Ok(folder),
    }
}

/// Returns true if `CRANNY_REQUIRE_ALL` is set to a value other than the empty string or `0`.
pub fn all_required() -> bool {
    env::var_os(REQUIRE_ALL).is_some_and(|value| !value.is_empty() && value != "0")
}

/// Resolves `value` relative to the folder `current`.
fn folder_of(value: Option<OsString>, current: &Path) -> Result<Option<PathBuf>, String> {
    let Some(value) = value.filter(|value| !value.is_empty()) else { return Ok(None) };
    // Tests run in the folders of their crates, where a relative path would resolve differently.
    let folder = current.join(value);
    if folder.join(RELEASE).is_dir() {
        // `..` is resolved if the system supports it; otherwise the path works unresolved.
        Ok(Some(folder.canonicalize().unwrap_or(folder)))
    } else {
        Err(format!("{DATA}: no folder `{RELEASE}` in {}", folder.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unset_and_empty_mean_no_data() {
        assert_eq!(folder_of(None, Path::new(".")), Ok(None));
        assert_eq!(folder_of(Some(OsString::new()), Path::new(".")), Ok(None));
    }

    #[test]
    fn a_relative_folder_becomes_absolute() {
        let outer = tempfile::tempdir().expect("temporary folder");
        std::fs::create_dir_all(outer.path().join("data").join(RELEASE)).expect("folder");
        std::fs::create_dir(outer.path().join("checkout")).expect("folder");
        let found = folder_of(Some("../data".into()), &outer.path().join("checkout"));
        let folder = found.expect("a data folder").expect("set");
        assert!(folder.is_absolute() && folder.join(RELEASE).is_dir(), "{}", folder.display());
        assert!(folder.ends_with("data"), "{}", folder.display());
    }

    #[test]
    fn a_folder_without_the_release_is_refused_by_name() {
        let empty = tempfile::tempdir().expect("temporary folder");
        let message = folder_of(Some(empty.path().into()), Path::new(".")).expect_err("no data in it");
        assert!(message.contains(&empty.path().display().to_string()), "{message}");
    }
}
