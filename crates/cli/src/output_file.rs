//! Output files of commands: only `--force` overwrites a file of another kind; files and folders are written atomically.

use std::path::{Path, PathBuf};

use cranny_scenario::{ScenarioError, check_writable, write_whole_file, write_whole_folder};

use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;

/// Checks, before the work begins, that a command can write `path`. Refuses folders, devices, read-only files, paths in folders
/// that do not exist, databases, and existing files of another kind unless `--force` is given.
///
/// An empty file, such as those of `mktemp`, is of every kind: it has no content to lose.
pub fn check(path: &Path, kind: FileKind, output: Output) -> Result<(), Failure> {
    check_folder(path)?;
    check_writable(path)?;
    let head = match cranny_file::head(path, FileKind::HEAD_BYTES) {
        Err(reason) if reason.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        head => head.map_err(|reason| ScenarioError::Unreadable { path: path.to_owned(), reason })?,
    };
    if DATABASE.iter().any(|begin| head.starts_with(begin)) {
        Err(Failure::Database { path: path.to_owned() })
    } else if output.force || head.is_empty() || kind.is_that_of(&head) {
        Ok(())
    } else {
        Err(Failure::OtherKind { path: path.to_owned(), kind: kind.name() })
    }
}

/// First bytes of a database of `SQLite`, of its write-ahead log in both orders of bytes, and of its journal
/// (<https://sqlite.org/fileformat.html>).
const DATABASE: [&[u8]; 4] =
    [b"SQLite format 3\0", b"\x37\x7f\x06\x82", b"\x37\x7f\x06\x83", b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7"];

/// Refuses a file in a folder that does not exist.
pub fn check_folder(path: &Path) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if folder.is_some_and(|folder| !folder.is_dir()) {
        return Err(Failure::NoFolder { path: path.to_owned() });
    }
    Ok(())
}

/// Returns true if an output path stands for several files: an existing folder, or a path with / at its end.
pub fn is_folder(path: &Path) -> bool {
    path.is_dir() || path.to_string_lossy().ends_with(std::path::is_separator)
}

/// Writes a file of a kind after a new [`check`]; an earlier one may be outdated.
pub fn write(path: &Path, kind: FileKind, content: &[u8], output: Output) -> Result<(), Failure> {
    check(path, kind, output)?;
    Ok(write_whole_file(path, content)?)
}

/// Writes the partial result of a stopped command and returns its path: beside an existing file that has content (`grasps.csv`
/// → `grasps.partial.csv`), which stays.
pub fn write_part(path: &Path, kind: FileKind, content: &[u8], output: Output) -> Result<PathBuf, Failure> {
    let is_free = std::fs::metadata(path).map_or(true, |found| found.len() == 0);
    let place = if is_free {
        path.to_owned()
    } else {
        let ending =
            path.extension().map_or_else(String::new, |ending| format!(".{}", ending.to_string_lossy()));
        path.with_extension(format!("partial{ending}"))
    };
    write(&place, kind, content, output)?;
    Ok(place)
}

/// File that belongs in a folder with others.
pub struct NamedFile {
    pub name: String,
    pub kind: FileKind,
    pub content: Vec<u8>,
}

/// Writes files into a folder. A new folder appears with all files or not at all; in an existing folder, all paths are checked
/// before the first file is written. Returns the paths.
pub fn write_all(folder: &Path, files: &[NamedFile], output: Output) -> Result<Vec<PathBuf>, Failure> {
    let place = |file: &NamedFile| folder.join(&file.name);
    if folder.is_dir() {
        for file in files {
            check(&place(file), file.kind, output)?;
        }
        for file in files {
            write_whole_file(&place(file), &file.content)?;
        }
    } else {
        write_whole_folder(folder, |folder| {
            files.iter().try_for_each(|file| write_whole_file(&folder.join(&file.name), &file.content))
        })?;
    }
    Ok(files.iter().map(place).collect())
}
