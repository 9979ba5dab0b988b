//! Hidden folders in which output is made before it is renamed to its destination.

use std::collections::BTreeSet;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use cranny_file::system::machine_name;

use crate::files::temporary::Temporary;

/// Hidden folder beside an output, in which it is made. No other program has its name, so that no link can await the content
/// there. It is removed when this value is dropped, or by the next output to the same folder if the program was killed: the
/// operating system then releases the lock of its mark.
#[derive(Debug)]
pub struct StagingFolder {
    // Closed before the folder is removed, which Windows demands.
    _mark: File,
    folder: Temporary,
}

const PREFIX: &str = ".cranny-";
const SUFFIX: &str = ".partial";

/// File that marks a folder as a staging folder, and is locked as long as the folder is used.
const MARK: &str = "mark";

/// Number of attempts to create a folder: another program may remove one that is not marked yet.
const ATTEMPTS: usize = 16;

impl StagingFolder {
    /// Creates a folder beside `output`, and removes those of programs that were killed.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn beside(output: &Path) -> io::Result<Self> {
        let parent = output.parent().filter(|parent| !parent.as_os_str().is_empty());
        let parent = parent.unwrap_or(Path::new("."));
        sweep_once(parent);
        let mut made = Self::make(parent);
        for _ in 1..ATTEMPTS {
            if made.as_ref().is_ok_and(Option::is_some) || made.as_ref().is_err_and(|fault| !is_gone(fault)) {
                break;
            }
            made = Self::make(parent);
        }
        made?.ok_or_else(|| io::Error::other("another program removes the temporary folders there"))
    }

    /// Creates a folder for temporary files in that of the system, and removes those of programs that were killed.
    ///
    /// # Errors
    /// Those of the operating system.
    pub(crate) fn temporary() -> io::Result<Self> {
        Self::beside(&std::env::temp_dir().join(MARK))
    }

    /// Path of the folder. It contains its mark, and is otherwise empty at first.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Creates a folder with its mark; `None` if another program removed it before it was marked.
    fn make(parent: &Path) -> io::Result<Option<Self>> {
        let folder = Temporary::folder_in(parent, PREFIX, SUFFIX)?;
        let path = folder.path().join(MARK);
        let mut mark = File::options().read(true).write(true).create_new(true).open(&path)?;
        // Where the file system has no locks, no other program can lock it either, so the folder is safe, but may stay.
        if let Err(TryLockError::WouldBlock) = mark.try_lock() {
            return Ok(None);
        }
        mark.write_all(mark_text().as_bytes())?;
        let is_there = fs::symlink_metadata(&path).is_ok();
        Ok(is_there.then_some(Self { _mark: mark, folder }))
    }
}

fn is_gone(fault: &io::Error) -> bool {
    fault.kind() == io::ErrorKind::NotFound
}

/// Returns the content of a mark. It names the machine, because the locks of a shared file system may be visible there alone.
fn mark_text() -> String {
    format!("temporary folder of cranny on {}\n", machine_name().unwrap_or_default())
}

/// Removes the abandoned staging folders in `parent`, once for each folder, which may have many entries.
fn sweep_once(parent: &Path) {
    static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let is_new = SWEPT.lock().unwrap_or_else(PoisonError::into_inner).insert(parent.to_owned());
    if is_new {
        sweep(parent);
    }
}

fn sweep(parent: &Path) {
    let Ok(entries) = fs::read_dir(parent) else { return };
    for entry in entries.filter_map(Result::ok) {
        let name = entry.file_name();
        let is_named = name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX));
        // A link is no folder here.
        if is_named && entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            // A folder that cannot be removed is left to its owner.
            let _ = remove_if_abandoned(&entry.path());
        }
    }
}

/// Removes a staging folder of a program that has ended, and nothing else.
fn remove_if_abandoned(folder: &Path) -> io::Result<()> {
    let path = folder.join(MARK);
    let is_file = match fs::symlink_metadata(&path) {
        // The program ended before it marked the folder; one with content is not removed.
        Err(fault) if is_gone(&fault) => return fs::remove_dir(folder),
        found => found?.is_file(),
    };
    if !is_file {
        return Ok(());
    }
    let mark = File::options().read(true).write(true).open(&path)?;
    if mark.try_lock().is_err() {
        return Ok(());
    }
    let mut text = String::new();
    (&mark).take(1024).read_to_string(&mut text)?;
    if text == mark_text() {
        fs::remove_dir_all(folder)
    } else if text.is_empty() && fs::read_dir(folder)?.count() == 1 {
        // The program ended before it wrote the mark, and thus before any content.
        fs::remove_file(&path)?;
        fs::remove_dir(folder)
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// A program may be killed at any moment of creating its folder; the mark that it leaves is not locked.
    #[test]
    fn the_folders_of_killed_programs_are_removed_and_nothing_else() {
        let root = tempfile::tempdir().unwrap();
        let folder = |name: &str| {
            let folder = root.path().join(format!("{PREFIX}{name}{SUFFIX}"));
            fs::create_dir(&folder).unwrap();
            folder
        };
        folder("unmarked");
        fs::write(folder("empty").join(MARK), "").unwrap();
        let killed = folder("killed");
        fs::create_dir(killed.join("set")).unwrap();
        fs::write(killed.join("set/half"), "written").unwrap();
        fs::write(killed.join(MARK), mark_text()).unwrap();
        // Those of others.
        fs::write(folder("other").join("content"), "").unwrap();
        let of_other_machine = folder("machine");
        fs::write(of_other_machine.join(MARK), mark_text() + "elsewhere").unwrap();
        fs::write(root.path().join(format!("{PREFIX}file{SUFFIX}")), "").unwrap();
        let half_marked = folder("foreign");
        fs::write(half_marked.join(MARK), "").unwrap();
        fs::write(half_marked.join("content"), "").unwrap();
        let used = StagingFolder::make(root.path()).unwrap().unwrap();
        fs::write(used.path().join("content"), "").unwrap();
        sweep(root.path());
        let mut left: Vec<String> =
            ["file", "foreign", "machine", "other"].map(|name| format!("{PREFIX}{name}{SUFFIX}")).into();
        left.push(used.path().file_name().unwrap().to_str().unwrap().to_owned());
        left.sort();
        assert_eq!(names(root.path()), left);
        assert_eq!(names(used.path()), ["content", MARK]);
        assert_eq!(names(&half_marked), ["content", MARK]);
        let path = used.path().to_owned();
        drop(used);
        assert!(!path.exists());
    }

    /// A link or a pipe in the place of a mark or a folder is neither followed nor waited for.
    #[cfg(unix)]
    #[test]
    fn links_and_pipes_are_left_alone() {
        use std::os::unix::fs::symlink;
        let root = tempfile::tempdir().unwrap();
        let precious = root.path().join("precious");
        fs::create_dir(&precious).unwrap();
        fs::write(precious.join(MARK), mark_text()).unwrap();
        symlink(&precious, root.path().join(format!("{PREFIX}link{SUFFIX}"))).unwrap();
        let mark = |name: &str| {
            let folder = root.path().join(format!("{PREFIX}{name}{SUFFIX}"));
            fs::create_dir(&folder).unwrap();
            folder.join(MARK)
        };
        for (name, target) in [("a", precious.join(MARK)), ("b", PathBuf::from("/dev/tty"))] {
            symlink(target, mark(name)).unwrap();
        }
        let made = std::process::Command::new("mkfifo").arg(mark("pipe")).status().unwrap();
        assert!(made.success());
        let before = names(root.path());
        let (done, swept) = std::sync::mpsc::channel();
        std::thread::spawn({
            let root = root.path().to_owned();
            move || {
                sweep(&root);
                let _ = done.send(());
            }
        });
        // Opening the pipe would wait for ever, or reading it fail.
        swept.recv_timeout(std::time::Duration::from_secs(10)).unwrap();
        assert_eq!((names(root.path()), names(&precious)), (before, vec![MARK.to_owned()]));
    }
}
