use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;
use std::sync::OnceLock;

use crate::FileFault;
use crate::system::{is_stream, kind_name};

/// A kind of file, read as a whole up to a maximum size.
///
/// A file named inside another file must be a regular file or a link to one: reading from a pipe or a device might never end,
/// and the user who opens a scenario does not see which files it names. A file named on the command line may be a pipe
/// ([`Self::argument`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Readable {
    what: &'static str,
    most_bytes: u64,
    takes_pipes: bool,
}

/// A text that people write: YAML, URDF, SRDF, a manifest. The largest known one, a scene of 10⁵ boxes, has 15 MiB.
pub const TEXT: Readable = Readable::new("such a text", 64 << 20);

/// Grasps, way points, plans, `NumPy` arrays: a million way points of nine joints take about 200 MiB.
pub const TABLE: Readable = Readable::new("a table", 1 << 30);

/// A mesh: ten million triangles in binary STL take 500 MiB.
pub const MESH: Readable = Readable::new("a mesh", 1 << 30);

/// A program, read for its checksum.
pub const PROGRAM: Readable = Readable::new("a program", 1 << 30);

/// A packed scenario, as stored on disk.
pub const ARCHIVE: Readable = Readable::new("an archive", 256 << 20);

/// First bytes of the text that replaces a file stored in Git LFS (its specification, version 1).
const LFS_POINTER: &[u8] = b"version https://git-lfs.github.com/spec/";

/// Set by `--large-files` at the start of a program. The setting is process-wide, because otherwise every reader of a file that
/// names other files would have to pass it on.
static LIFTED: OnceLock<()> = OnceLock::new();

/// Lifts the size limits: from now on this process reads files of any size.
pub fn lift_limits() {
    let _ = LIFTED.set(());
}

/// Returns true if [`lift_limits`] was called.
pub fn are_limits_lifted() -> bool {
    LIFTED.get().is_some()
}

impl Readable {
    const fn new(what: &'static str, most_bytes: u64) -> Self {
        Self { what, most_bytes, takes_pipes: false }
    }

    /// Returns this kind of file for command-line arguments, which may also be pipes, such as `/dev/stdin` or the shell's
    /// `<(…)`.
    #[must_use]
    pub const fn argument(self) -> Self {
        Self { takes_pipes: true, ..self }
    }

    /// Returns the content of the file.
    ///
    /// # Errors
    /// A [`FileFault`] as the reason of the [`io::Error`], or another error of the operating system.
    pub fn bytes(self, path: &Path) -> io::Result<Vec<u8>> {
        self.check(path)?;
        let most = self.most_bytes();
        let mut bytes = Vec::new();
        // A file may grow while it is read, and a pipe has no size.
        File::open(path)
            .and_then(|file| file.take(most.saturating_add(1)).read_to_end(&mut bytes))
            .map_err(|fault| FileFault::of(path, fault))?;
        if bytes.len() as u64 > most {
            return Err(FileFault::TooLarge { what: self.what, size: None, most }.into());
        }
        if bytes.starts_with(LFS_POINTER) {
            return Err(FileFault::LfsPointer.into());
        }
        Ok(bytes)
    }

    /// Returns the content of the file as text.
    ///
    /// # Errors
    /// As [`Self::bytes`], and [`FileFault::NotText`].
    pub fn text(self, path: &Path) -> io::Result<String> {
        String::from_utf8(self.bytes(path)?).map_err(|fault| {
            let sound = &fault.as_bytes()[..fault.utf8_error().valid_up_to()];
            FileFault::NotText { line: sound.split(|byte| *byte == b'\n').count() }.into()
        })
    }

    /// Checks that [`Self::bytes`] would open the file, for readers that open it themselves.
    ///
    /// # Errors
    /// As [`Self::bytes`].
    pub fn check(self, path: &Path) -> io::Result<()> {
        let found = fs::metadata(path).map_err(|fault| FileFault::of(path, fault))?;
        let kind = found.file_type();
        if kind.is_dir() {
            return Err(FileFault::Folder.into());
        }
        let is_taken = kind.is_file() || (self.takes_pipes && is_stream(kind));
        if !is_taken {
            return Err(FileFault::NotRegular { kind: kind_name(kind) }.into());
        }
        let most = self.most_bytes();
        if kind.is_file() && found.len() > most {
            return Err(FileFault::TooLarge { what: self.what, size: Some(found.len()), most }.into());
        }
        Ok(())
    }

    fn most_bytes(self) -> u64 {
        if are_limits_lifted() { u64::MAX } else { self.most_bytes }
    }
}

/// Returns true if a file or folder exists; missing permission to check is an error, not `false`.
///
/// # Errors
/// [`FileFault::Denied`] as the reason, or another error of the operating system.
pub fn is_there(path: &Path) -> io::Result<bool> {
    match fs::metadata(path) {
        Ok(_) => Ok(true),
        // The last two kinds are for names that no file can have.
        Err(fault)
            if matches!(
                fault.kind(),
                io::ErrorKind::NotFound
                    | io::ErrorKind::NotADirectory
                    | io::ErrorKind::InvalidInput
                    | io::ErrorKind::InvalidFilename
            ) =>
        {
            Ok(false)
        }
        Err(fault) => Err(FileFault::of(path, fault)),
    }
}
