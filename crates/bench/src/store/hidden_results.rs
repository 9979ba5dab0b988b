//! Results files that external programs must not see: they hold answers, and a reader can lock them.

use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use cranny_file::system::open_plain_file;

use crate::store::results_file::{APPLICATION, beside, folder_of};

/// Returns the real paths of all results files in the folder of `path`, each with the files that `SQLite` keeps beside it. A process
/// that has one of them open must not call this: closing a file releases all locks of its process on it.
pub fn results_beside(path: &Path) -> Vec<PathBuf> {
    /// More than any folder of results has: each file is examined once for each trial.
    const MOST_FILES: usize = 100_000;
    let Ok(path) = fs::canonicalize(path) else { return Vec::new() };
    let entries = fs::read_dir(folder_of(&path)).into_iter().flatten().flatten().take(MOST_FILES);
    // A link hides the file that it leads to, with its log.
    let others = entries.map(|entry| entry.path()).filter(|other| *other != path && is_results(other));
    let others = others.filter_map(|other| fs::canonicalize(other).ok());
    let with_logs = |path: PathBuf| {
        let logs = ["-wal", "-shm", "-journal"].map(|ending| beside(&path, ending));
        std::iter::once(path).chain(logs)
    };
    // Requests to workers are text.
    let files = others.chain([path.clone()]).flat_map(with_logs);
    files.filter(|path| path.to_str().is_some()).collect()
}

/// Returns true if a file is a database with the mark of results (<https://sqlite.org/fileformat.html>, section 1.3).
fn is_results(path: &Path) -> bool {
    const MARK_OFFSET: usize = 68;
    /// A database consists of pages, whose size is a multiple of this.
    const PAGE: u64 = 512;
    if fs::metadata(path).is_ok_and(|facts| facts.len() % PAGE != 0 || facts.len() == 0) {
        return false;
    }
    let mut header = [0; MARK_OFFSET + 4];
    let is_read = open_plain_file(path).and_then(|mut file| file.read_exact(&mut header)).is_ok();
    let mark = u32::from_be_bytes([header[68], header[69], header[70], header[71]]);
    is_read && header.starts_with(b"SQLite format 3\0") && i64::from(mark) == APPLICATION
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Results;

    #[test]
    fn results_are_found_with_their_logs_and_other_files_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().canonicalize().unwrap().join(name);
        for name in ["a.db", "b"] {
            Results::create(&path(name)).unwrap();
        }
        fs::write(path("planner.py"), "print()").unwrap();
        fs::write(path("other.db"), [b"SQLite format 3\0".as_slice(), &[0; 496]].concat()).unwrap();
        // A link is of another length than its file.
        let elsewhere = tempfile::tempdir().unwrap();
        let linked = elsewhere.path().canonicalize().unwrap().join("c.db");
        Results::create(&linked).unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(&linked, path("link.db")).unwrap();
        let found = results_beside(&path("a.db"));
        #[cfg(unix)]
        assert!(found.contains(&linked) && found.contains(&beside(&linked, "-wal")));
        for name in ["a.db", "a.db-wal", "a.db-shm", "a.db-journal", "b", "b-wal", "b-shm", "b-journal"] {
            assert!(found.contains(&path(name)), "{name}");
        }
        assert_eq!(found.len(), if cfg!(unix) { 12 } else { 8 });
    }
}
