use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use crate::files::atomic_file::{put_in_place, write_into};
use crate::{Rejections, ScenarioError};

/// Set that is being made, in a folder beside its destination: not a hidden one, because it stays if the set is stopped or the
/// program is killed, until the same set is made again.
///
/// A list in the folder is mark, lock and progress in one: its first line names the set, and the others the finished members.
/// Members that are not in the list are made again.
#[derive(Debug)]
pub(crate) struct UnfinishedSet {
    folder: PathBuf,
    known: BTreeMap<usize, Finished>,
    list: Mutex<List>,
}

/// List of the finished members, locked as long as it is open.
#[derive(Debug)]
struct List {
    file: File,
    is_empty: bool,
}

/// Finished member of a set.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Finished {
    /// Number of the member in its set, from 0.
    pub number: usize,
    /// Its line of the index; `None` if no draw was sound.
    pub line: Option<Line>,
    pub rejected: Rejections,
}

/// Line of the index.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Line {
    pub id: String,
    pub parameter_m: f64,
    pub x_m: f64,
    pub y_m: f64,
    pub yaw_rad: f64,
    pub clutter: usize,
    pub grasps: usize,
}

#[derive(PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    format: String,
    identity: String,
}

const FORMAT: &str = "cranny-unfinished-set/1";

const LIST: &str = "unfinished.jsonl";

impl UnfinishedSet {
    /// Opens the unfinished set of that identity beside `place`, or begins it.
    ///
    /// # Errors
    /// [`ScenarioError::Exists`] if the folder belongs to another program, [`ScenarioError::Unwritable`] also while another
    /// program makes the same set.
    pub fn open(place: &Path, identity: &str) -> Result<Self, ScenarioError> {
        // `a/b/` is treated as `a/b`.
        let mut name = place.components().as_path().as_os_str().to_owned();
        name.push(format!(".unfinished-{}", identity.get(..8).unwrap_or(identity)));
        let folder = PathBuf::from(name);
        let foreign = || ScenarioError::Exists { path: folder.clone() };
        let unwritable = |reason| ScenarioError::Unwritable { path: folder.clone(), reason };
        let list = folder.join(LIST);
        fs::create_dir_all(&folder).map_err(unwritable)?;
        match fs::symlink_metadata(&list) {
            Ok(found) if !found.is_file() => return Err(foreign()),
            _ => {}
        }
        let mut file =
            File::options().read(true).append(true).create(true).open(&list).map_err(unwritable)?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(unwritable(io::Error::other("another program is making the same scenarios")));
        }
        let head = Head { format: FORMAT.to_owned(), identity: identity.to_owned() };
        let mut text = Vec::new();
        file.read_to_end(&mut text).map_err(unwritable)?;
        // A line without an end was cut short.
        let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let mut lines = text[..whole].split_inclusive(|byte| *byte == b'\n');
        let mut known = BTreeMap::new();
        match lines.next() {
            Some(first) if serde_json::from_slice::<Head>(first).is_ok_and(|first| first == head) => {
                file.set_len(whole as u64).map_err(unwritable)?;
                // A full disk may have cut a line short, too; its member is made again.
                for finished in lines.filter_map(|line| serde_json::from_slice::<Finished>(line).ok()) {
                    known.insert(finished.number, finished);
                }
            }
            // The program ended before it wrote the first line, and thus before any member.
            None if fs::read_dir(&folder).map_err(unwritable)?.count() == 1 => {
                file.set_len(0).map_err(unwritable)?;
                append(&mut file, &head).map_err(|reason| {
                    let _ = fs::remove_dir_all(&folder);
                    unwritable(reason)
                })?;
            }
            _ => return Err(foreign()),
        }
        let list = List { file, is_empty: known.is_empty() };
        Ok(Self { folder, known, list: Mutex::new(list) })
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the member of that number if an earlier run finished it.
    pub fn finished(&self, number: usize) -> Option<Finished> {
        self.known.get(&number).cloned()
    }

    /// Returns the path of a member's folder, and removes what an earlier run left there unfinished.
    pub fn free_folder(&self, id: &str) -> Result<PathBuf, ScenarioError> {
        let path = self.folder.join(id);
        match fs::remove_dir_all(&path) {
            Err(reason) if reason.kind() != io::ErrorKind::NotFound => {
                Err(ScenarioError::Unwritable { path, reason })
            }
            _ => Ok(path),
        }
    }

    /// Adds a member, all files of which are written, to the list.
    pub fn add(&self, finished: &Finished) -> Result<(), ScenarioError> {
        let mut list = self.list.lock().unwrap_or_else(PoisonError::into_inner);
        list.is_empty = false;
        append(&mut list.file, finished)
            .map_err(|reason| ScenarioError::Unwritable { path: self.folder.join(LIST), reason })
    }

    /// Ends the work for now: the folder stays if a member is finished, and is returned.
    pub fn keep(self) -> Option<PathBuf> {
        if self.list.lock().unwrap_or_else(PoisonError::into_inner).is_empty {
            self.remove();
            None
        } else {
            Some(self.folder)
        }
    }

    /// Removes the folder.
    pub fn remove(self) {
        drop(self.list);
        // The same set, made again, uses the remainder.
        let _ = fs::remove_dir_all(&self.folder);
    }

    /// Writes the index and moves the set to its destination.
    pub fn complete(self, place: &Path, index: &str) -> Result<(), ScenarioError> {
        write_into(&self.folder, "index.csv", index)?;
        // On Windows, a folder with an open file cannot be renamed.
        drop(self.list);
        let unwritable = |reason| ScenarioError::Unwritable { path: place.to_owned(), reason };
        put_in_place(&self.folder, place).map_err(unwritable)?;
        // The set is complete even with the list.
        let _ = fs::remove_file(place.join(LIST));
        Ok(())
    }
}

/// Appends a line in one call, so that lines of several threads do not mix.
fn append(file: &mut File, row: &impl Serialize) -> io::Result<()> {
    let mut line = serde_json::to_vec(row)?;
    line.push(b'\n');
    file.write_all(&line)
}
