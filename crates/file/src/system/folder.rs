use std::fs::{self, Metadata};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Least size at which an entry of a folder counts, in bytes: an empty file also takes memory or a part of the disk.
const ENTRY_BYTES: u64 = 4096;

/// Returns the allocated size of everything in a folder, in bytes. Links are not followed. The count ends above `most`; a folder
/// too deep for a path counts as [`u64::MAX`]. Folders that this user may not read are made readable (Unix).
pub fn folder_bytes(folder: &Path, most: u64) -> u64 {
    let mut bytes = 0;
    let mut left = vec![folder.to_owned()];
    while let Some(folder) = left.pop() {
        let entries = match fs::read_dir(&folder) {
            Err(reason) if reason.kind() == ErrorKind::InvalidFilename => return u64::MAX,
            Err(reason) if reason.kind() == ErrorKind::PermissionDenied => {
                make_accessible(&folder).and_then(|()| fs::read_dir(&folder))
            }
            entries => entries,
        };
        // Entries may vanish meanwhile.
        for entry in entries.into_iter().flatten().flatten() {
            let Ok(facts) = entry.metadata() else { continue };
            bytes += allocated_bytes(&facts).max(ENTRY_BYTES);
            if bytes > most {
                return bytes;
            }
            if facts.is_dir() {
                left.push(entry.path());
            }
        }
    }
    bytes
}

/// Removes a folder with everything in it, for at most `patience`. Neither modes nor depth prevent this (Unix): nested folders are
/// moved up, so that no path is longer than two levels. Links are not followed.
///
/// # Errors
/// [`ErrorKind::TimedOut`], or the error of the operating system; the folder then still exists.
pub fn remove_folder(folder: &Path, patience: Duration) -> io::Result<()> {
    let mut removal = Removal { top: folder, deadline: Instant::now().checked_add(patience), moved: 0 };
    make_accessible(folder)?;
    while removal.remove_two_levels()? {}
    fs::remove_dir(folder)
}

/// Removal of a folder.
struct Removal<'a> {
    top: &'a Path,
    deadline: Option<Instant>,
    /// Number of names that were tried for folders that were moved up.
    moved: u64,
}

impl Removal<'_> {
    /// Removes the entries of the folder with their own entries; deeper folders become entries of the folder. Returns true if
    /// there were any.
    fn remove_two_levels(&mut self) -> io::Result<bool> {
        let mut was_there = false;
        for entry in fs::read_dir(self.top)? {
            let entry = entry?;
            was_there = true;
            if !entry.file_type()?.is_dir() {
                self.remove_file(&entry.path())?;
                continue;
            }
            make_accessible(&entry.path())?;
            for below in fs::read_dir(entry.path())? {
                let below = below?;
                if below.file_type()?.is_dir() {
                    self.move_up(&below.path())?;
                } else {
                    self.remove_file(&below.path())?;
                }
            }
            fs::remove_dir(entry.path())?;
        }
        Ok(was_there)
    }

    fn remove_file(&self, path: &Path) -> io::Result<()> {
        self.check_time()?;
        fs::remove_file(path)
    }

    fn move_up(&mut self, path: &Path) -> io::Result<()> {
        // Its entry for the parent folder changes.
        make_accessible(path)?;
        loop {
            self.check_time()?;
            self.moved += 1;
            match fs::rename(path, self.top.join(self.moved.to_string())) {
                // The name is in use.
                Err(reason)
                    if matches!(
                        reason.kind(),
                        ErrorKind::AlreadyExists | ErrorKind::DirectoryNotEmpty | ErrorKind::NotADirectory
                    ) => {}
                moved => return moved,
            }
        }
    }

    fn check_time(&self) -> io::Result<()> {
        let is_over = self.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        if is_over { Err(ErrorKind::TimedOut.into()) } else { Ok(()) }
    }
}

/// Gives the owner of a folder all rights to it (Unix).
fn make_accessible(folder: &Path) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        fs::set_permissions(folder, fs::Permissions::from_mode(0o700))
    }
    #[cfg(not(unix))]
    {
        let _ = folder;
        Ok(())
    }
}

/// Returns the allocated size of a file, in bytes; its length on systems without blocks.
fn allocated_bytes(facts: &Metadata) -> u64 {
    #[cfg(unix)]
    {
        /// Unit of the number of blocks of a file, independent of the file system (stat(2)).
        const BLOCK_BYTES: u64 = 512;
        std::os::unix::fs::MetadataExt::blocks(facts).saturating_mul(BLOCK_BYTES)
    }
    #[cfg(not(unix))]
    facts.len()
}

/// Folder in the mount namespace of another process. It can be read as long as this value exists, also after the process (Linux).
#[derive(Debug)]
pub struct ProcessFolder {
    #[cfg(target_os = "linux")]
    folder: fs::File,
}

impl ProcessFolder {
    /// Opens a folder as `process` sees it.
    ///
    /// # Errors
    /// The error of the operating system; [`ErrorKind::Unsupported`] on systems other than Linux.
    pub fn open(process: u32, path: &Path) -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        {
            // An absolute link in the path would lead out of the namespace.
            let path = fs::canonicalize(path)?;
            let folder = fs::File::open(format!("/proc/{process}/root{}", path.display()))?;
            Ok(Self { folder })
        }
        #[cfg(not(target_os = "linux"))]
        {
            let _ = (process, path);
            Err(ErrorKind::Unsupported.into())
        }
    }

    /// Returns a path of the folder for this process.
    pub fn path(&self) -> PathBuf {
        #[cfg(target_os = "linux")]
        {
            use std::os::fd::AsRawFd as _;
            PathBuf::from(format!("/proc/self/fd/{}", self.folder.as_raw_fd()))
        }
        #[cfg(not(target_os = "linux"))]
        PathBuf::new()
    }

    /// Returns the used size of its file system, in bytes; 0 if unknown.
    pub fn used_bytes(&self) -> u64 {
        #[cfg(target_os = "linux")]
        if let Ok(facts) = rustix::fs::fstatvfs(&self.folder) {
            return facts.f_blocks.saturating_sub(facts.f_bfree).saturating_mul(facts.f_frsize);
        }
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATIENCE: Duration = Duration::from_secs(30);

    /// Creates folders within each other, each through the current path of the outermost one, so that no path is too long.
    fn nest(top: &Path, levels: usize) {
        for level in 0..levels {
            let (inner, outer) = (top.join("inner"), top.join("outer"));
            fs::create_dir(&outer).unwrap();
            fs::write(outer.join(level.to_string()), "x").unwrap();
            if inner.exists() {
                fs::rename(&inner, outer.join("inner")).unwrap();
            }
            fs::rename(&outer, &inner).unwrap();
        }
    }

    #[test]
    fn a_folder_of_any_depth_is_removed() {
        let above = tempfile::tempdir().unwrap();
        let folder = above.path().join("folder");
        fs::create_dir(&folder).unwrap();
        nest(&folder, 3000);
        // Names that the removal would give.
        fs::create_dir_all(folder.join("1/2/3")).unwrap();
        fs::write(folder.join("2"), "a file").unwrap();
        remove_folder(&folder, PATIENCE).unwrap();
        assert!(!folder.exists());
    }

    #[test]
    fn the_removal_has_a_limit_of_time_and_follows_no_link() {
        let above = tempfile::tempdir().unwrap();
        let folder = above.path().join("folder");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("a"), "").unwrap();
        assert_eq!(remove_folder(&folder, Duration::ZERO).unwrap_err().kind(), ErrorKind::TimedOut);
        #[cfg(unix)]
        {
            let other = tempfile::tempdir().unwrap();
            fs::write(other.path().join("b"), "").unwrap();
            std::os::unix::fs::symlink(other.path(), folder.join("link")).unwrap();
            remove_folder(&folder, PATIENCE).unwrap();
            assert!(other.path().join("b").exists() && !folder.exists());
        }
    }

    #[cfg(unix)]
    #[test]
    fn modes_hide_nothing_from_count_and_removal() {
        use std::os::unix::fs::PermissionsExt as _;
        let above = tempfile::tempdir().unwrap();
        let folder = above.path().join("folder");
        let hidden = folder.join("a/b");
        fs::create_dir_all(&hidden).unwrap();
        fs::write(hidden.join("c"), vec![1; 1 << 20]).unwrap();
        for closed in [&hidden, &folder.join("a"), &folder] {
            fs::set_permissions(closed, fs::Permissions::from_mode(0o000)).unwrap();
        }
        let bytes = folder_bytes(&folder, u64::MAX);
        assert!((1 << 20..2 << 20).contains(&bytes), "{bytes}");
        fs::set_permissions(&hidden, fs::Permissions::from_mode(0o555)).unwrap();
        remove_folder(&folder, PATIENCE).unwrap();
        assert!(!folder.exists());
    }

    #[test]
    fn the_size_of_a_folder_counts_entries_without_content_and_ends_at_the_limit() {
        let folder = tempfile::tempdir().unwrap();
        for name in 0..100 {
            fs::write(folder.path().join(name.to_string()), "").unwrap();
        }
        assert_eq!(folder_bytes(folder.path(), u64::MAX), 100 * ENTRY_BYTES);
        assert_eq!(folder_bytes(folder.path(), 10 * ENTRY_BYTES), 11 * ENTRY_BYTES);
        nest(folder.path(), 3000);
        assert_eq!(folder_bytes(folder.path(), u64::MAX - 1), u64::MAX);
    }
}
