pub use crate::opener::open_plain_file;

/// Identity of a file: two paths with the same one name the same file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileIdentity {
    /// Device and inode number; both 0 on systems without them, so that every file is taken for the same one.
    device_and_inode: (u64, u64),
}

impl FileIdentity {
    /// Returns the identity of an existing file.
    pub fn of(facts: &std::fs::Metadata) -> Self {
        #[cfg(unix)]
        let device_and_inode = {
            use std::os::unix::fs::MetadataExt as _;
            (facts.dev(), facts.ino())
        };
        #[cfg(not(unix))]
        let device_and_inode = {
            let _ = facts;
            (0, 0)
        };
        Self { device_and_inode }
    }
}
