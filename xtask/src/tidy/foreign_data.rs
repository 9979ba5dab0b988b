//! Check that no file of the released data is committed, because others own them.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// Minimum size of compared files, in bytes; shorter files (an empty list, a one-line stub) can be equal by chance.
const LEAST_BYTES: u64 = 200;

/// Reports files that are, byte for byte, a file of the data folder.
///
/// # Errors
/// If the data folder cannot be read completely.
pub fn check(files: &[SourceFile], data: &Path) -> Result<Vec<Problem>, String> {
    let mut by_size = HashMap::new();
    collect(data, &mut by_size).map_err(|error| format!("{}: {error}", data.display()))?;
    let mut problems = Vec::new();
    for file in files {
        let candidates = by_size.get(&(file.bytes.len() as u64)).map_or(&[][..], Vec::as_slice);
        for candidate in candidates {
            let bytes =
                std::fs::read(candidate).map_err(|error| format!("{}: {error}", candidate.display()))?;
            if bytes == file.bytes {
                let inside = candidate.strip_prefix(data).unwrap_or(candidate);
                problems.push(Problem::new(
                    &file.path,
                    format!("is `{}` of the released data", inside.display()),
                    "remove it: tests read it from CRANNY_DATA, what ships is written from dimensions",
                ));
                break;
            }
        }
    }
    Ok(problems)
}

/// Adds the files below `folder` to `by_size`, in the order of their paths.
fn collect(folder: &Path, by_size: &mut HashMap<u64, Vec<PathBuf>>) -> std::io::Result<()> {
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
    paths.sort();
    for path in paths {
        let metadata = std::fs::metadata(&path)?;
        if metadata.is_dir() {
            collect(&path, by_size)?;
        } else if metadata.len() >= LEAST_BYTES {
            by_size.entry(metadata.len()).or_default().push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_fails_under_any_name_and_nothing_else_does() {
        let data = tempfile::tempdir().expect("temporary folder");
        let folder = data.path().join("jogramop/meshes");
        std::fs::create_dir_all(&folder).expect("folder");
        let mesh = "v 0 0 1\n".repeat(40);
        std::fs::write(folder.join("table.obj"), &mesh).expect("write");
        std::fs::write(folder.join("stub.csv"), "1,2,3\n").expect("write");

        let files = [
            SourceFile::of_text("robots/renamed.obj", &mesh),
            SourceFile::of_text("robots/same_length.obj", &mesh.replace('1', "2")),
            SourceFile::of_text("robots/stub.csv", "1,2,3\n"),
        ];
        let problems = check(&files, data.path()).expect("readable");
        assert_eq!(problems.len(), 1);
        assert_eq!(problems[0].place, "robots/renamed.obj");
        assert!(problems[0].message.contains("table.obj"));
    }

    #[test]
    fn an_unreadable_folder_is_an_error() {
        assert!(check(&[], Path::new("no such folder")).is_err());
    }
}
