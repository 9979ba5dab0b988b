use std::fs;
use std::path::Path;
use std::time::SystemTime;

/// Metadata of a file that differ after every change of the file; on Unix even if its times are set back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileStamp {
    bytes: u64,
    modified: Option<SystemTime>,
    /// Device, inode number, and time of the last change of content or attributes, which no program can set.
    inode: (u64, u64, i64, i64),
}

impl FileStamp {
    /// Returns the stamp of a file; `None` if the path is not a file.
    pub fn of(path: &Path) -> Option<Self> {
        let facts = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
        #[cfg(unix)]
        let inode = {
            use std::os::unix::fs::MetadataExt as _;
            (facts.dev(), facts.ino(), facts.ctime(), facts.ctime_nsec())
        };
        #[cfg(not(unix))]
        let inode = (0, 0, 0, 0);
        Some(Self { bytes: facts.len(), modified: facts.modified().ok(), inode })
    }
}
