use std::fs::{File, FileType};
use std::io;
use std::path::Path;

/// Opens a file for reading without waiting for anything (Unix): for the writer of a pipe, or for new lines of a file of the
/// kernel's such as `/proc/kmsg`, whose reading then fails.
///
/// # Errors
/// Those of the operating system.
pub fn open_without_waiting(path: &Path) -> io::Result<File> {
    #[cfg(unix)]
    {
        use rustix::fs::{Mode, OFlags, open};
        let flags = OFlags::RDONLY | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
        Ok(open(path, flags, Mode::empty())?.into())
    }
    #[cfg(not(unix))]
    File::open(path)
}

/// Returns true if bytes can be read from an entry that is no file: a pipe, or a device such as a terminal.
pub fn is_stream(kind: FileType) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        kind.is_fifo() || kind.is_char_device()
    }
    #[cfg(not(unix))]
    {
        let _ = kind;
        true
    }
}

/// Returns the name of a kind of entry that is neither file nor folder, with its article.
pub fn kind_name(kind: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        match kind {
            _ if kind.is_fifo() => return "a pipe",
            _ if kind.is_socket() => return "a socket",
            _ => {}
        }
    }
    let _ = kind;
    "a device"
}
