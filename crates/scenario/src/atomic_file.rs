use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;

use crate::ScenarioError;

/// Writes a file as a whole or not at all: what stood there before stays until the new content is complete.
pub(crate) fn write(path: &Path, content: &str) -> Result<(), ScenarioError> {
    let partial = partial_of(path);
    let written = File::create(&partial)
        .and_then(|mut file| {
            file.write_all(content.as_bytes())?;
            file.sync_all()
        })
        .and_then(|()| fs::rename(&partial, path));
    written.map_err(|reason| {
        // The rest of a failed attempt; that it cannot be removed is no second fault.
        let _ = fs::remove_file(&partial);
        ScenarioError::Unwritable { path: path.to_owned(), reason }
    })
}

/// Whether a file could be written there, found out without touching what stands there.
pub(crate) fn check(path: &Path) -> Result<(), ScenarioError> {
    let unwritable = |reason| ScenarioError::Unwritable { path: path.to_owned(), reason };
    if path.is_dir() {
        return Err(unwritable(std::io::ErrorKind::IsADirectory.into()));
    }
    let partial = partial_of(path);
    File::create(&partial).and_then(|_| fs::remove_file(&partial)).map_err(unwritable)
}

fn partial_of(path: &Path) -> std::path::PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.partial", std::process::id()));
    path.with_file_name(name)
}
