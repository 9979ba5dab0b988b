//! Temporary files and folders of this process: none of them remains when it ends, or comes into place afterwards.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Temporary file or folder. It is removed on drop, and by [`exit_without_temporaries`].
#[derive(Debug)]
pub struct Temporary {
    path: PathBuf,
}

/// Paths of all temporary files and folders of this process.
static KNOWN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn known() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Temporary {
    /// Creates a folder for temporary files of the system.
    ///
    /// # Errors
    /// Returns the error of the operating system.
    pub fn folder() -> io::Result<Self> {
        Self::folder_in(&std::env::temp_dir(), "", "")
    }

    /// Creates a folder in another one; its name is random between `prefix` and `suffix`.
    ///
    /// # Errors
    /// Returns the error of the operating system.
    pub fn folder_in(parent: &Path, prefix: &str, suffix: &str) -> io::Result<Self> {
        let mut known = known();
        let mut name = tempfile::Builder::new();
        name.prefix(prefix).suffix(suffix).disable_cleanup(true);
        // Unlike `tempdir_in`, this does not put the random name into errors.
        let path = name.make_in(parent, |path| std::fs::create_dir(path))?.path().to_owned();
        known.insert(path.clone());
        Ok(Self { path })
    }

    /// Path of the file or folder.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Runs `action`, before or after which [`exit_without_temporaries`] may end the process, but not meanwhile.
pub(crate) fn uninterrupted<T>(action: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
    let _known = known();
    action()
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let mut known = known();
        if known.remove(&self.path) {
            remove(&self.path);
        }
    }
}

/// Ends the process with an exit code from any thread, and removes its temporary files and folders before. Those that other
/// threads write neither remain nor come into place.
pub fn exit_without_temporaries(code: i32) -> ! {
    // The lock stays closed: nothing else is registered or moved into place until the end.
    let known = known();
    known.iter().for_each(|path| remove(path));
    std::process::exit(code)
}

/// Removes a file or folder; a failure is not reported.
fn remove(path: &Path) {
    /// Number of attempts, because another thread may still add files to a folder.
    const ATTEMPTS: usize = 100;
    if path.symlink_metadata().is_ok_and(|found| !found.is_dir()) {
        let _ = std::fs::remove_file(path);
        return;
    }
    for _ in 0..ATTEMPTS {
        if std::fs::remove_dir_all(path).is_ok() || !path.exists() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_temporary_folder_is_gone_after_its_use_unless_it_came_into_place() {
        let root = tempfile::tempdir().unwrap();
        let folder = Temporary::folder_in(root.path(), ".a-", "").unwrap();
        std::fs::write(folder.path().join("file"), "x").unwrap();
        let path = folder.path().to_owned();
        assert!(known().contains(&path));
        drop(folder);
        assert!(!path.exists() && !known().contains(&path));

        let folder = Temporary::folder_in(root.path(), ".b-", "").unwrap();
        let (path, place) = (folder.path().to_owned(), root.path().join("b"));
        uninterrupted(|| std::fs::rename(&path, &place)).unwrap();
        drop(folder);
        assert!(place.is_dir() && !path.exists() && !known().contains(&path));
    }
}
