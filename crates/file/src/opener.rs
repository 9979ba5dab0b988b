use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;
use std::sync::OnceLock;

use crate::FileFault;
use crate::system::{is_stream, kind_name};

/// How a kind of file is read: whole, up to a size.
///
/// A file that is named inside another must be a regular one, or a link to one: from a pipe or a device a reader
/// might wait or read for ever, and nobody who opens a scenario sees what it names. What a person names on the
/// command line may be a pipe ([`Self::argument`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Readable {
    what: &'static str,
    most_bytes: u64,
    takes_pipes: bool,
}

/// A text that people write: YAML, URDF, SRDF, a manifest. The largest known to us, a scene of 10⁵ boxes, has 15 MiB.
pub const TEXT: Readable = Readable::new("such a text", 64 << 20);

/// Grasps, way points, plans, arrays of `NumPy`: a million way points of nine joints have about 200 MiB.
pub const TABLE: Readable = Readable::new("a table", 1 << 30);

/// A mesh: ten million triangles in binary STL have 500 MiB.
pub const MESH: Readable = Readable::new("a mesh", 1 << 30);

/// A program, read for its checksum.
pub const PROGRAM: Readable = Readable::new("a program", 1 << 30);

/// A packed scenario, as it lies on the disk.
pub const ARCHIVE: Readable = Readable::new("an archive", 256 << 20);

/// The beginning of the text that stands for a file whose content lies in Git LFS (its specification, version 1).
const LFS_POINTER: &[u8] = b"version https://git-lfs.github.com/spec/";

/// Set at the start of a program, if at all: `--large-files`. A process-wide setting, because files are named in
/// files that are named in files, and every reader on that way, in every crate, would have to carry it otherwise.
static LIFTED: OnceLock<()> = OnceLock::new();

/// From now on this process reads files of any size.
pub fn lift_limits() {
    let _ = LIFTED.set(());
}

/// Whether [`lift_limits`] was called.
pub fn are_limits_lifted() -> bool {
    LIFTED.get().is_some()
}

impl Readable {
    const fn new(what: &'static str, most_bytes: u64) -> Self {
        Self { what, most_bytes, takes_pipes: false }
    }

    /// The same for what a person names: also a pipe, such as `/dev/stdin` or the shell's `<(…)`.
    #[must_use]
    pub const fn argument(self) -> Self {
        Self { takes_pipes: true, ..self }
    }

    /// The content of the file.
    ///
    /// # Errors
    /// A [`FileFault`] as the reason of the [`io::Error`], or what else the operating system says.
    pub fn bytes(self, path: &Path) -> io::Result<Vec<u8>> {
        self.check(path)?;
        let most = self.most_bytes();
        let mut bytes = Vec::new();
        // A file may grow, and a pipe has no size.
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

    /// The content of the file as text.
    ///
    /// # Errors
    /// As [`Self::bytes`], and [`FileFault::NotText`].
    pub fn text(self, path: &Path) -> io::Result<String> {
        String::from_utf8(self.bytes(path)?).map_err(|fault| {
            let sound = &fault.as_bytes()[..fault.utf8_error().valid_up_to()];
            FileFault::NotText { line: sound.split(|byte| *byte == b'\n').count() }.into()
        })
    }

    /// Whether [`Self::bytes`] would open the file, for readers that do so themselves.
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

/// Whether a file or folder is there; that it may not be looked at is no "no".
///
/// # Errors
/// [`FileFault::Denied`] as the reason, or what else the operating system says.
pub fn is_there(path: &Path) -> io::Result<bool> {
    match fs::metadata(path) {
        Ok(_) => Ok(true),
        // The last two are names that nothing can have.
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
