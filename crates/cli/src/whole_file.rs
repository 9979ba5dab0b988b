use std::ffi::OsString;
use std::fs;
use std::path::Path;

use crate::failure::Failure;

/// Writes a file as a whole or not at all: what stood there before stays until the new content is complete.
pub fn write(path: &Path, content: &[u8]) -> Result<(), Failure> {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.partial", std::process::id()));
    let partial = path.with_file_name(name);
    fs::write(&partial, content).and_then(|()| fs::rename(&partial, path)).map_err(|reason| {
        // The rest of a failed attempt; that it cannot be removed is no second fault.
        let _ = fs::remove_file(&partial);
        Failure::Unwritable { path: path.to_owned(), reason }
    })
}

/// Makes a folder and those above it, if they are not there.
pub fn make_folder(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|reason| Failure::Unwritable { path: path.to_owned(), reason })
}
