use std::io;
use std::path::Path;

use crate::spelling::{nearest_files, suggested};

/// Setting that lifts a size limit, for messages: on the command line, and in Python.
pub const LIFTED_BY: &str = "--large-files, or lift_file_limits() in Python,";

/// Reason why a file is not read. It is the inner error of an [`io::Error`], so that each reader reports it with the name of
/// the file in its own error.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FileFault {
    /// The file does not exist.
    #[error("file not found{}", suggested(near))]
    Missing {
        /// Files beside it with a similar name.
        near: Vec<String>,
    },
    /// The operating system does not let this user read the file or enter its folder.
    #[error("no permission to read it (see its owner and mode, and those of the folders above it)")]
    Denied,
    /// The path is a folder, not a file.
    #[error("it is a folder, not a file")]
    Folder,
    /// The path is a pipe, a device or a socket where only a regular file is allowed.
    #[error("it is {kind}, not a regular file")]
    NotRegular {
        /// Kind of the entry, with its article.
        kind: &'static str,
    },
    /// The file is larger than its kind allows.
    #[error(
        "{what} may hold at most {}, but this one holds {} ({LIFTED_BY} lifts this limit)",
        mebibytes(*most),
        size.map_or_else(|| "more".to_owned(), mebibytes)
    )]
    TooLarge {
        /// Kind of file that was expected, with its article.
        what: &'static str,
        /// Its size in bytes; `None` for a pipe.
        size: Option<u64>,
        /// The limit, in bytes.
        most: u64,
    },
    /// The file contains a Git LFS pointer instead of its content.
    #[error("it is a Git LFS pointer, not the file itself: `git lfs pull` in its repository fetches that")]
    LfsPointer,
    /// The bytes are not UTF-8 text.
    #[error("line {line} is not UTF-8 text: is it the right file?")]
    NotText {
        /// First line that is not UTF-8, counted from 1.
        line: usize,
    },
}

impl FileFault {
    /// Converts an error of the operating system to a [`FileFault`], if there is one for it.
    pub(crate) fn of(path: &Path, error: io::Error) -> io::Error {
        let fault = match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => {
                Self::Missing { near: nearest_files(path) }
            }
            io::ErrorKind::PermissionDenied => Self::Denied,
            io::ErrorKind::IsADirectory => Self::Folder,
            _ => return error,
        };
        io::Error::new(error.kind(), fault)
    }
}

impl From<FileFault> for io::Error {
    fn from(fault: FileFault) -> Self {
        Self::new(io::ErrorKind::InvalidData, fault)
    }
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}
