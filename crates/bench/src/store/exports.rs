use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use cranny_file::system::{open_plain_file, remove_folder};

use crate::BenchError;

/// Temporary folder that an external program may have written to. It is removed on drop, whatever the program did to it.
#[derive(Debug)]
pub struct ExportFolder {
    path: PathBuf,
}

impl ExportFolder {
    /// Creates a new folder within `above`; its name begins with `prefix`.
    pub fn new_in(above: &Path, prefix: &str) -> io::Result<Self> {
        let folder = tempfile::Builder::new().prefix(prefix).tempdir_in(above)?;
        Ok(Self { path: folder.keep() })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Removes the folder. Returns false if something stays.
    pub fn remove(mut self) -> bool {
        remove_folder(&std::mem::take(&mut self.path), PATIENCE).is_ok()
    }
}

impl Drop for ExportFolder {
    fn drop(&mut self) {
        // It is gone already, or a later campaign tries again.
        let _ = remove_folder(&self.path, PATIENCE);
    }
}

/// Time limit for removing the files of a program: enough for a million.
const PATIENCE: Duration = Duration::from_secs(30);

/// Folder for input and output of external programs. It is removed with its campaign, or by a later one if that was killed.
#[derive(Debug)]
pub struct Exports {
    folder: ExportFolder,
    /// Lock that marks the folder as used; the system releases it at any end of the campaign.
    _lock: File,
}

const PREFIX: &str = "cranny-bench-";
const LOCK: &str = "lock";

impl Exports {
    pub fn new() -> Result<Self, BenchError> {
        sweep(&std::env::temp_dir());
        let make = || -> io::Result<Self> {
            let folder = ExportFolder::new_in(&std::env::temp_dir(), PREFIX)?;
            let lock = File::create(folder.path().join(LOCK))?;
            // On a file system without locks a later campaign may remove the folder once this one has ended.
            let _ = lock.try_lock();
            Ok(Self { folder, _lock: lock })
        };
        make().map_err(|reason| BenchError::NotRunnable {
            program: "a campaign, which needs a temporary folder".to_owned(),
            reason,
        })
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Returns the folder of the campaign that `exports` of a worker belong to, and those of other campaigns beside it.
pub fn folders_of_campaigns(exports: &Path) -> Vec<PathBuf> {
    let Some(own) = exports.parent() else { return Vec::new() };
    let others = own.parent().map(entries).into_iter().flatten().map(|entry| entry.path());
    others.chain([own.to_owned()]).collect()
}

/// Returns the folders of campaigns in the folder of temporary files.
fn entries(temporary: &Path) -> impl Iterator<Item = fs::DirEntry> {
    fs::read_dir(temporary).into_iter().flatten().flatten().filter(|entry| {
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        is_folder && entry.file_name().to_string_lossy().starts_with(PREFIX)
    })
}

/// Removes the folders of ended campaigns.
fn sweep(temporary: &Path) {
    for entry in entries(temporary) {
        // A folder that cannot be removed belongs to another user, or has a lock that no campaign makes.
        let _ = match open_plain_file(&entry.path().join(LOCK)) {
            Ok(lock) if lock.try_lock().is_ok() => remove_folder(&entry.path(), PATIENCE),
            // Its campaign was killed before locking, or during removal; a recent folder may still be in creation.
            Err(fault) if fault.kind() == io::ErrorKind::NotFound && is_old(&entry) => {
                remove_folder(&entry.path(), PATIENCE)
            }
            _ => Ok(()),
        };
    }
}

/// Returns true if the last change of a folder is older than the time needed to create one.
fn is_old(folder: &fs::DirEntry) -> bool {
    const MAKING: Duration = Duration::from_mins(1);
    let changed = folder.metadata().and_then(|facts| facts.modified()).ok();
    changed.and_then(|changed| changed.elapsed().ok()).is_some_and(|since| since > MAKING)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_of_campaigns_that_are_gone_are_swept_and_those_of_others_stay() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = |name: &str, has_lock: bool| {
            let folder = temporary.path().join(name);
            fs::create_dir_all(folder.join("1-abc")).unwrap();
            has_lock.then(|| File::create(folder.join(LOCK)).unwrap())
        };
        let running = folder("cranny-bench-a", true);
        running.as_ref().unwrap().lock().unwrap();
        drop(folder("cranny-bench-b", true));
        folder("cranny-bench-c", false);
        let unlocked = |name: &str, age_s: u64| {
            let folder = temporary.path().join(name);
            fs::create_dir_all(folder.join("worker-a")).unwrap();
            let made = std::time::SystemTime::now() - Duration::from_secs(age_s);
            File::open(folder).unwrap().set_modified(made).unwrap();
        };
        unlocked("cranny-bench-d", 0);
        unlocked("cranny-bench-e", 3600);
        drop(folder("other", true));
        sweep(temporary.path());
        let mut left: Vec<_> =
            fs::read_dir(temporary.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, ["cranny-bench-a", "cranny-bench-c", "cranny-bench-d", "other"]);
    }

    /// Opening a pipe waits for its other end, also after SIGTERM; a folder can be locked like a file.
    #[cfg(unix)]
    #[test]
    fn a_lock_that_is_no_file_blocks_nothing_and_its_folder_stays() {
        let temporary = tempfile::tempdir().unwrap();
        let place = |name: &str| {
            let folder = temporary.path().join(name);
            fs::create_dir_all(&folder).unwrap();
            folder.join(LOCK)
        };
        let made = std::process::Command::new("mkfifo").arg(place("cranny-bench-a")).status().unwrap();
        assert!(made.success());
        let _socket = std::os::unix::net::UnixListener::bind(place("cranny-bench-b")).unwrap();
        fs::create_dir(place("cranny-bench-c")).unwrap();
        std::os::unix::fs::symlink("/dev/zero", place("cranny-bench-d")).unwrap();
        let other = tempfile::tempdir().unwrap();
        fs::write(other.path().join(LOCK), "").unwrap();
        std::os::unix::fs::symlink(other.path(), temporary.path().join("cranny-bench-e")).unwrap();
        sweep(temporary.path());
        assert_eq!(fs::read_dir(temporary.path()).unwrap().count(), 5);
        assert!(other.path().join(LOCK).exists());
    }
}
