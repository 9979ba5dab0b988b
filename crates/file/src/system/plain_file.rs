use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;

use crate::FileFault;
use crate::system::kind_name;

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

/// Opens an existing regular file for reading. A pipe without a writer does not block, even if it takes the place of a file
/// at this moment.
///
/// # Errors
/// [`FileFault::Folder`] and [`FileFault::NotRegular`] as the reason of the [`io::Error`], or another error of the operating
/// system.
pub fn open_plain_file(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt as _;
        options.custom_flags(OFlags::NONBLOCK.bits().cast_signed());
    }
    let file = options.open(path)?;
    let kind = file.metadata()?.file_type();
    if kind.is_dir() {
        return Err(FileFault::Folder.into());
    }
    if !kind.is_file() {
        return Err(FileFault::NotRegular { kind: kind_name(kind) }.into());
    }
    Ok(file)
}
