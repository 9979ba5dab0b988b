//! Where commands write: never over a file of another kind unless `--force` says so, and a file or a folder as a
//! whole or not at all.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use cranny_scenario::{ScenarioError, check_writable, write_whole_file, write_whole_folder};

use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;

/// Refuses what a command would write to `path`, before it has worked for it: a file that is there and of another
/// kind, unless `--force` was given; a folder, a device, a file that is read-only, and where there is no folder.
///
/// An empty file is of every kind: nothing is lost with it, and `mktemp` makes such.
pub fn check(path: &Path, kind: FileKind, output: Output) -> Result<(), Failure> {
    check_folder(path)?;
    check_writable(path)?;
    if output.force {
        return Ok(());
    }
    let head = match File::open(path) {
        Err(reason) if reason.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(reason) => return Err(ScenarioError::Unreadable { path: path.to_owned(), reason }.into()),
        Ok(file) => {
            let mut head = Vec::new();
            let read = file.take(FileKind::HEAD_BYTES).read_to_end(&mut head);
            read.map_err(|reason| ScenarioError::Unreadable { path: path.to_owned(), reason })?;
            head
        }
    };
    if head.is_empty() || kind.is_that_of(&head) {
        Ok(())
    } else {
        Err(Failure::OtherKind { path: path.to_owned(), kind: kind.name() })
    }
}

/// Refuses a file in a folder that is not there.
pub fn check_folder(path: &Path) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if folder.is_some_and(|folder| !folder.is_dir()) {
        return Err(Failure::NoFolder { path: path.to_owned() });
    }
    Ok(())
}

/// Whether a place that is written to is meant for several files: a folder, or with a / at its end.
pub fn is_folder(path: &Path) -> bool {
    path.is_dir() || path.to_string_lossy().ends_with(std::path::is_separator)
}

/// Writes a file of a kind; [`check`] may have been asked long before.
pub fn write(path: &Path, kind: FileKind, content: &[u8], output: Output) -> Result<(), Failure> {
    check(path, kind, output)?;
    Ok(write_whole_file(path, content)?)
}

/// Writes a part of what was asked for, of a command that was stopped: what stands there already stays, and the part is
/// written beside it (`grasps.csv` → `grasps.partial.csv`). Returns the file.
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

/// A file that belongs into a folder with others.
pub struct NamedFile {
    pub name: String,
    pub kind: FileKind,
    pub content: Vec<u8>,
}

/// Writes files into a folder: a new one appears with all of them or not at all; in one that is there, all places
/// are looked at before the first file is written. Returns where they are.
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
