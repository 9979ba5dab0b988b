//! Where the paper's released data lie, and whether a run may go without.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Environment variable that names the data folder.
pub const DATA: &str = "CRANNY_DATA";
/// Environment variable under which nothing may be skipped.
pub const REQUIRE_ALL: &str = "CRANNY_REQUIRE_ALL";
/// What a run without data says.
pub const SKIPPED: &str = "SKIPPED: tests on released data (set CRANNY_DATA)";

/// The folder that the data folder must hold.
const RELEASE: &str = "jogramop";

/// The data folder as an absolute path, `None` if `CRANNY_DATA` is unset or empty.
///
/// # Errors
/// If the variable names something that is not the data folder, or nothing where all is required.
pub fn folder() -> Result<Option<PathBuf>, String> {
    let current = env::current_dir().map_err(|error| format!("the current folder: {error}"))?;
    match folder_of(env::var_os(DATA), &current)? {
        None if all_required() => {
            Err(format!("{REQUIRE_ALL} is set, but {DATA} is not: name the folder of the released data"))
        }
        folder => Ok(folder),
    }
}

/// Whether `CRANNY_REQUIRE_ALL` is set to anything but nothing or `0`.
pub fn all_required() -> bool {
    env::var_os(REQUIRE_ALL).is_some_and(|value| !value.is_empty() && value != "0")
}

/// The folder that `value`, read in the folder `current`, names.
fn folder_of(value: Option<OsString>, current: &Path) -> Result<Option<PathBuf>, String> {
    let Some(value) = value.filter(|value| !value.is_empty()) else { return Ok(None) };
    // Tests run in the folders of their crates, where a relative path would mean another place.
    let folder = current.join(value);
    if folder.join(RELEASE).is_dir() {
        // `..` is resolved where the system can do it; it works as it stands where it cannot.
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
