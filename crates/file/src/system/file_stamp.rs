use std::fs;
use std::path::Path;
use std::time::SystemTime;

/// What the system says of a file: as long as it says the same, nobody has changed it. On Unix that holds whatever its times
/// were set to; elsewhere a program that sets them back is not noticed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileStamp {
    bytes: u64,
    modified: Option<SystemTime>,
    /// Device, number, and when content or attributes were last changed, which no program can set.
    inode: (u64, u64, i64, i64),
}

impl FileStamp {
    /// Nothing for what is no file.
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
