use std::fs::{self, File, Metadata};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::FileFault;
use crate::system::{is_stream, kind_name, open_without_waiting};

/// A kind of file, read as a whole up to a maximum size.
///
/// A file must be a regular file or a link to one: reading from a pipe or a device might never end, and the user who opens a
/// scenario does not see which files it names. Only a path that a person names may be a pipe ([`accept_streams`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Readable {
    what: &'static str,
    most_bytes: u64,
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

/// Arguments of the command, which may be pipes. Process-wide for the same reason.
static ACCEPTED: OnceLock<Vec<PathBuf>> = OnceLock::new();

/// Lifts the size limits: from now on this process reads files of any size.
pub fn lift_limits() {
    let _ = LIFTED.set(());
}

/// Returns true if [`lift_limits`] was called.
pub fn are_limits_lifted() -> bool {
    LIFTED.get().is_some()
}

/// Accepts pipes at these paths, such as `/dev/stdin` or the shell's `<(…)`. Every other path, in particular one that is named in
/// a file, must lead to a regular file. Only the first call counts: a program passes its arguments at its start.
pub fn accept_streams(paths: Vec<PathBuf>) {
    let _ = ACCEPTED.set(paths);
}

/// Returns the first bytes of a regular file, at most `most_bytes`.
///
/// # Errors
/// As [`Readable::bytes`], except for the size.
pub fn head(path: &Path, most_bytes: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open_plain_file(path)?.take(most_bytes).read_to_end(&mut bytes)?;
    Ok(bytes)
}

impl Readable {
    const fn new(what: &'static str, most_bytes: u64) -> Self {
        Self { what, most_bytes }
    }

    /// Returns the content of the file.
    ///
    /// # Errors
    /// A [`FileFault`] as the reason of the [`io::Error`], or another error of the operating system.
    pub fn bytes(self, path: &Path) -> io::Result<Vec<u8>> {
        let takes_streams = ACCEPTED.get().is_some_and(|accepted| accepted.iter().any(|named| named == path));
        let file = open(path, takes_streams)?;
        let most = if are_limits_lifted() { u64::MAX } else { self.most_bytes };
        let too_large = |size| FileFault::TooLarge { what: self.what, size, most };
        let found = file.metadata()?;
        if found.is_file() && found.len() > most {
            return Err(too_large(Some(found.len())).into());
        }
        let mut bytes = Vec::new();
        // A file may grow while it is read, and a pipe has no size.
        file.take(most.saturating_add(1))
            .read_to_end(&mut bytes)
            .map_err(|fault| FileFault::of(path, fault))?;
        if bytes.len() as u64 > most {
            return Err(too_large(None).into());
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
}

/// Opens an existing regular file for reading. A pipe without a writer does not block, even if it takes the place of a file
/// at this moment.
///
/// # Errors
/// As [`Readable::bytes`], except for the size.
pub fn open_plain_file(path: &Path) -> io::Result<File> {
    open(path, false)
}

/// Opens a regular file, or also a pipe or a device if `takes_streams` is true.
///
/// The kind is checked before opening, because opening a device may change it, and again afterwards: another file may have taken
/// its place. Neither opening nor reading waits, unless the path may be a stream.
fn open(path: &Path, takes_streams: bool) -> io::Result<File> {
    let check = |found: io::Result<Metadata>| -> io::Result<bool> {
        let kind = found.map_err(|fault| FileFault::of(path, fault))?.file_type();
        if kind.is_dir() {
            return Err(FileFault::Folder.into());
        }
        let is_taken_stream = takes_streams && is_stream(kind);
        if kind.is_file() || is_taken_stream {
            Ok(is_taken_stream)
        } else {
            Err(FileFault::NotRegular { kind: kind_name(kind) }.into())
        }
    };
    let waits = check(fs::metadata(path))?;
    let opened = if waits { File::open(path) } else { open_without_waiting(path) };
    let file = opened.map_err(|fault| FileFault::of(path, fault))?;
    check(file.metadata())?;
    Ok(file)
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
