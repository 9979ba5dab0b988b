//! Reading of untrusted zip archives.

use std::collections::{BTreeMap, HashSet};
use std::io::{Cursor, Read as _};
use std::path::Path;

use cranny_file::{LIFTED_BY, are_limits_lifted, excerpt};
use zip::ZipArchive;

use crate::ScenarioError;

/// Maximum unpacked size of an archive, in bytes: the largest known scenario has 20 MiB, most of it meshes.
const MOST_BYTES: u64 = 256 << 20;

/// Maximum ratio of unpacked to packed size: about 4 to 10 for meshes and tables as text, about a thousand for an attack.
const MOST_SHRUNK: u64 = 100;

/// Unpacked size, in bytes, up to which any compression ratio is accepted.
const SMALL_BYTES: u64 = 16 << 20;

/// Returns the files of an archive by path. Before unpacking, it refuses names that no scenario needs (see [`check_names`]),
/// links, and more than [`MOST_BYTES`] or [`MOST_SHRUNK`]; while unpacking, files larger than declared.
pub(crate) fn contents(path: &Path, bytes: &[u8]) -> Result<BTreeMap<String, Vec<u8>>, ScenarioError> {
    let broken = |reason: &dyn std::fmt::Display| {
        fault(path, format!("is not a complete zip archive ({reason}); was it cut short in transfer?"))
    };
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|reason| broken(&reason))?;
    let directory = usize::try_from(archive.central_directory_start()).unwrap_or(usize::MAX);
    let listed = cranny_file::archive_names(bytes.get(directory..).unwrap_or_default());
    if listed.len() < archive.len() {
        return Err(broken(&"its directory cannot be found"));
    }
    let files: Vec<&str> = listed.iter().map(String::as_str).filter(|name| !name.ends_with('/')).collect();
    check_names(files.into_iter()).map_err(|problem| fault(path, problem))?;
    let mut declared: u64 = 0;
    for index in 0..archive.len() {
        let entry = archive.by_index_raw(index).map_err(|reason| broken(&reason))?;
        declared = declared.saturating_add(entry.size());
        check_size(declared, bytes.len() as u64).map_err(|problem| fault(path, problem))?;
    }
    let mut contents = BTreeMap::new();
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(|reason| broken(&reason))?;
        let name = entry.name().map_err(|reason| broken(&reason))?.into_owned();
        if name.ends_with('/') {
            continue;
        }
        check_names(std::iter::once(name.as_str())).map_err(|problem| fault(path, problem))?;
        if entry.is_symlink() {
            return Err(fault(path, format!("'{}' is a link; nothing is unpacked", excerpt(&name))));
        }
        let mut content = Vec::new();
        let size = entry.size();
        let read = entry.by_ref().take(size.saturating_add(1)).read_to_end(&mut content);
        read.map_err(|reason| fault(path, format!("'{}' is broken: {reason}", excerpt(&name))))?;
        if content.len() as u64 != size {
            return Err(fault(path, format!("'{}' does not have its stated size", excerpt(&name))));
        }
        contents.insert(name, content);
    }
    Ok(contents)
}

/// Checks that an archive of `packed` bytes may unpack to `unpacked` bytes.
pub(crate) fn check_size(unpacked: u64, packed: u64) -> Result<(), String> {
    if are_limits_lifted() || unpacked <= SMALL_BYTES {
        return Ok(());
    }
    let mebibytes = |bytes: u64| bytes >> 20;
    if unpacked > MOST_BYTES {
        let (unpacked, most) = (mebibytes(unpacked), mebibytes(MOST_BYTES));
        return Err(format!(
            "unpacks to {unpacked} MiB or more, but at most {most} MiB are unpacked ({LIFTED_BY} lifts this limit)"
        ));
    }
    if unpacked / MOST_SHRUNK > packed {
        return Err(format!(
            "unpacks to {} MiB or more, over {MOST_SHRUNK} times its own size, as no scenario does ({LIFTED_BY} lifts \
             this limit)",
            mebibytes(unpacked)
        ));
    }
    Ok(())
}

/// Checks that the files of an archive are not hidden, as none are packed, and can be unpacked on any system, each to its own
/// path in the folder; the error describes the first that cannot.
pub(crate) fn check_names<'n>(names: impl Iterator<Item = &'n str>) -> Result<(), String> {
    let mut taken = HashSet::new();
    for name in names {
        if name.is_empty()
            || name.starts_with('/')
            || name.split('/').any(|part| matches!(part, "" | "." | ".."))
            || name.contains(['\\', ':', '\0'])
        {
            return Err(format!("'{}' would leave the folder; nothing is unpacked", excerpt(name)));
        }
        if let Some(part) = name.split('/').find(|part| !is_portable(part)) {
            return Err(format!(
                "'{}' is no name for a file on every system: '{}'",
                excerpt(name),
                excerpt(part)
            ));
        }
        if name.split('/').any(|part| part.starts_with('.')) {
            return Err(format!("'{}' is hidden, and a packed scenario has no hidden files", excerpt(name)));
        }
        if !taken.insert(name.to_lowercase()) {
            return Err(format!(
                "holds '{}' twice (capitals make no difference on every system)",
                excerpt(name)
            ));
        }
    }
    Ok(())
}

/// Names of devices on Windows, with any extension.
const DEVICES: [&str; 6] = ["con", "prn", "aux", "nul", "conin$", "conout$"];

fn is_portable(part: &str) -> bool {
    let stem = part.split('.').next().unwrap_or_default().trim_end().to_lowercase();
    let is_digit = |number: &str| "0123456789¹²³".chars().any(|digit| number == digit.to_string());
    let is_port = ["com", "lpt"].iter().any(|port| stem.strip_prefix(port).is_some_and(is_digit));
    part.len() <= 255
        && !part.ends_with(['.', ' '])
        && !part.contains(['<', '>', '"', '|', '?', '*'])
        && !part.contains(char::is_control)
        && !DEVICES.contains(&stem.as_str())
        && !is_port
}

pub(crate) fn fault(archive: &Path, problem: impl Into<String>) -> ScenarioError {
    ScenarioError::Content { path: archive.to_owned(), problem: problem.into() }
}
