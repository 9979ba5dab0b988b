//! Files and folders that are written atomically.
//!
//! All content is written in a [`StagingFolder`] beside its destination and renamed when it is complete. A failure before that (a
//! full disk, a quota, Ctrl-C) leaves nothing behind and does not change what existed there.

use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::ScenarioError;
use crate::files::staging_folder::StagingFolder;
use crate::files::temporary::uninterrupted;

/// Name of a file or folder in its staging folder.
const CONTENT: &str = "content";

/// Writes a file atomically. If `path` is a link, its target is replaced and the link stays.
///
/// # Errors
/// [`ScenarioError::Unwritable`], also for a folder, a device, and a read-only file.
pub fn write_whole_file(path: &Path, content: &[u8]) -> Result<(), ScenarioError> {
    write_whole_file_by(path, |partial| {
        let written = File::create_new(partial).and_then(|mut file| {
            file.write_all(content)?;
            file.sync_all()
        });
        written.map_err(|reason| ScenarioError::Unwritable { path: path.to_owned(), reason })
    })
}

/// Writes a file atomically, as [`write_whole_file`] does, with `fill`, which creates the file at the path passed to it. That path
/// has no extension.
///
/// # Errors
/// As [`write_whole_file`], and those of `fill`.
pub fn write_whole_file_by<E: From<ScenarioError>>(
    path: &Path,
    fill: impl FnOnce(&Path) -> Result<(), E>,
) -> Result<(), E> {
    let unwritable = |reason| ScenarioError::Unwritable { path: path.to_owned(), reason };
    let place = place_of(path).map_err(unwritable)?;
    let staging = StagingFolder::beside(&place).map_err(unwritable)?;
    let partial = staging.path().join(CONTENT);
    fill(&partial)?;
    Ok(uninterrupted(|| fs::rename(&partial, &place)).map_err(unwritable)?)
}

/// Checks that a file can be written at `path`, without touching an existing file.
///
/// # Errors
/// As [`write_whole_file`].
pub fn check_writable(path: &Path) -> Result<(), ScenarioError> {
    let made = place_of(path).and_then(|place| StagingFolder::beside(&place));
    made.map(drop).map_err(|reason| ScenarioError::Unwritable { path: path.to_owned(), reason })
}

/// Checks that a folder can be created at `place`: it does not exist, or is an empty folder.
///
/// # Errors
/// [`ScenarioError::Exists`], [`ScenarioError::Unreadable`].
pub fn check_free_folder(place: &Path) -> Result<(), ScenarioError> {
    let unreadable = |reason| ScenarioError::Unreadable { path: place.to_owned(), reason };
    let is_free = match fs::symlink_metadata(place) {
        Ok(found) => found.is_dir() && fs::read_dir(place).map_err(unreadable)?.next().is_none(),
        Err(reason) => reason.kind() == std::io::ErrorKind::NotFound,
    };
    // A path without a name of its own (`.`) has no siblings.
    if is_free && place.file_name().is_some() {
        Ok(())
    } else {
        Err(ScenarioError::Exists { path: place.to_owned() })
    }
}

/// Creates a folder and its missing parents, with everything that `fill` writes to the folder passed to it, or nothing.
///
/// # Errors
/// As [`check_free_folder`], [`ScenarioError::Unwritable`], and those of `fill`.
pub fn write_whole_folder<T>(
    place: &Path,
    fill: impl FnOnce(&Path) -> Result<T, ScenarioError>,
) -> Result<T, ScenarioError> {
    let unwritable = |reason| ScenarioError::Unwritable { path: place.to_owned(), reason };
    check_free_folder(place)?;
    // `a/b/` is treated as `a/b`, also when a sibling name is derived from it.
    let place: PathBuf = place.components().collect();
    // The topmost new folder: all folders below it appear with it.
    let is_new = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
    let top = place.ancestors().take_while(is_new).last().unwrap_or(&place);
    let staging = StagingFolder::beside(top).map_err(unwritable)?;
    let partial = staging.path().join(CONTENT);
    let inside = place.strip_prefix(top).map_or_else(|_| partial.clone(), |below| partial.join(below));
    let written =
        fs::create_dir_all(&inside).map_err(unwritable).and_then(|()| fill(&inside)).and_then(|filled| {
            uninterrupted(|| put_in_place(&partial, top)).map(|()| filled).map_err(unwritable)
        });
    written.map_err(|fault| moved(fault, &inside, &place))
}

/// Renames a folder to a free path, or to an empty folder, which not every system lets a rename replace.
///
/// # Errors
/// Those of the operating system.
pub fn put_in_place(partial: &Path, place: &Path) -> std::io::Result<()> {
    if place.is_dir() {
        fs::remove_dir(place)?;
    }
    fs::rename(partial, place)
}

/// Writes a file in a folder that is not yet at its destination, and creates the parent folders.
pub(crate) fn write_into(folder: &Path, name: &str, content: impl AsRef<[u8]>) -> Result<(), ScenarioError> {
    let path = folder.join(name);
    let written =
        fs::create_dir_all(path.parent().unwrap_or(folder)).and_then(|()| fs::write(&path, content));
    written.map_err(|reason| ScenarioError::Unwritable { path, reason })
}

/// Returns the fault with its path mapped to the final destination.
fn moved(fault: ScenarioError, from: &Path, to: &Path) -> ScenarioError {
    let place = |path: PathBuf| path.strip_prefix(from).map(|below| to.join(below)).unwrap_or(path);
    match fault {
        ScenarioError::Unwritable { path, reason } => ScenarioError::Unwritable { path: place(path), reason },
        other => other,
    }
}

/// Returns the path to which the content of a file is written: the file itself, or the target of a link.
fn place_of(path: &Path) -> std::io::Result<PathBuf> {
    use std::io::ErrorKind::{IsADirectory, NotFound};
    match fs::symlink_metadata(path) {
        Err(reason) if reason.kind() == NotFound => Ok(path.to_owned()),
        Err(reason) => Err(reason),
        Ok(found) => {
            let is_link = found.is_symlink();
            let place = if is_link { fs::canonicalize(path)? } else { path.to_owned() };
            let found = if is_link { fs::metadata(&place)? } else { found };
            if found.is_dir() {
                return Err(IsADirectory.into());
            }
            if !found.is_file() {
                return Err(std::io::Error::other("it is a device or a pipe, not a file"));
            }
            if found.permissions().readonly() {
                return Err(std::io::Error::other("it is read-only"));
            }
            Ok(place)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_folder_that_cannot_be_filled_leaves_nothing_not_even_those_above_it() {
        let root = tempfile::tempdir().unwrap();
        let place = root.path().join("a/b/c");
        let fault = write_whole_folder(&place, |folder| {
            fs::write(folder.join("half"), "written").unwrap();
            write_whole_file(&folder.join("no/such/folder"), b"")
        });
        // The message names the destination, not the temporary folder.
        assert!(fault.unwrap_err().to_string().contains("a/b/c/no/such/folder"));
        assert_eq!(names(root.path()), Vec::<String>::new());
        write_whole_folder(&place, |folder| write_whole_file(&folder.join("whole"), b"x")).unwrap();
        assert_eq!(names(root.path()), ["a"]);
        assert_eq!(names(&place), ["whole"]);
        let again = write_whole_folder(&place, |_| Ok(()));
        assert!(matches!(again, Err(ScenarioError::Exists { .. })));
    }

    #[test]
    fn an_empty_folder_is_filled_and_a_relative_one_is_made_where_we_stand() {
        let root = tempfile::tempdir().unwrap();
        let place = root.path().join("empty/");
        fs::create_dir(&place).unwrap();
        write_whole_folder(&place, |folder| write_whole_file(&folder.join("whole"), b"x")).unwrap();
        assert_eq!((names(root.path()), names(&place)), (vec!["empty".into()], vec!["whole".into()]));
    }

    /// `-o /dev/sda` must not replace the device by a file, and a results page behind a link stays there.
    #[cfg(unix)]
    #[test]
    fn links_are_followed_to_files_and_nowhere_else() {
        use std::os::unix::fs::symlink;
        let root = tempfile::tempdir().unwrap();
        let (file, link) = (root.path().join("file"), root.path().join("link"));
        fs::write(&file, "before").unwrap();
        symlink(&file, &link).unwrap();
        write_whole_file(&link, b"after").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"after");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        for (name, target) in [("null", "/dev/null"), ("folder", "/"), ("nowhere", "no/such/file")] {
            let link = root.path().join(name);
            symlink(target, &link).unwrap();
            assert!(write_whole_file(&link, b"").is_err(), "{name}");
            assert!(check_writable(&link).is_err(), "{name}");
        }
        assert!(write_whole_file(Path::new("/dev/null"), b"").is_err());
        assert_eq!(names(root.path()).len(), 5);
    }

    /// Partial names used to be made of the name of the file and the number of the process.
    #[cfg(unix)]
    #[test]
    fn a_link_at_a_guessed_partial_name_is_not_followed() {
        use std::os::unix::fs::symlink;
        let root = tempfile::tempdir().unwrap();
        let (file, victim) = (root.path().join("plan.json"), root.path().join("victim"));
        fs::write(&victim, "precious").unwrap();
        let guessed = |name: &str| root.path().join(format!(".{name}.{}.partial", std::process::id()));
        symlink(&victim, guessed("plan.json")).unwrap();
        symlink(root.path(), guessed("folder")).unwrap();
        check_writable(&file).unwrap();
        write_whole_file(&file, b"plan").unwrap();
        write_whole_folder(&root.path().join("folder"), |_| Ok(())).unwrap();
        assert_eq!(fs::read(&victim).unwrap(), b"precious");
        assert_eq!(fs::read(&file).unwrap(), b"plan");
        assert_eq!(names(root.path()).len(), 5);
    }

    /// The name of a partial file must not be longer than that of its file.
    #[test]
    fn a_name_of_the_greatest_length_can_be_written() {
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("n".repeat(255));
        write_whole_file(&file, b"content").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"content");
    }
}
