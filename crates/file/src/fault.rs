use std::io;
use std::path::Path;

use crate::spelling::{nearest_files, suggested};

/// What lifts a limit, for messages: on the command line, and in Python.
pub const LIFTED_BY: &str = "--large-files, or lift_file_limits() in Python,";

/// Why a file is not read. It comes as the reason of an [`io::Error`], so that each reader says it with the name of
/// the file in its own error.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FileFault {
    /// Nothing is there.
    #[error("there is no such file{}", suggested(near))]
    Missing {
        /// Files beside it with a similar name.
        near: Vec<String>,
    },
    /// The operating system does not let this user read it, or enter the folder that it is in.
    #[error("no permission to read it (see its owner and mode, and those of the folders above it)")]
    Denied,
    /// A folder stands where a file is meant.
    #[error("it is a folder, not a file")]
    Folder,
    /// A pipe, a device or a socket stands where only a file's own content will do.
    #[error("it is {kind}, not a regular file")]
    NotRegular {
        /// What it is.
        kind: &'static str,
    },
    /// The file is larger than what its kind may be.
    #[error(
        "{what} may hold at most {}, but this one holds {} ({LIFTED_BY} lifts this limit)",
        mebibytes(*most),
        size.map_or_else(|| "more".to_owned(), mebibytes)
    )]
    TooLarge {
        /// What it was read as, with its article.
        what: &'static str,
        /// Its size in bytes; not known of a pipe.
        size: Option<u64>,
        /// The limit, in bytes.
        most: u64,
    },
    /// Git has put a pointer in the file's place, because its content lies in Git LFS.
    #[error("it is a Git LFS pointer, not the file itself: `git lfs pull` in its repository fetches that")]
    LfsPointer,
    /// The bytes are no text.
    #[error("line {line} is no text (UTF-8): is it the right file?")]
    NotText {
        /// The first line that is none, from 1.
        line: usize,
    },
}

impl FileFault {
    /// The words for what the operating system says, where there are any.
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
