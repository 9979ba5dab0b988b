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
/// Members that are not in the list are made again. The members are in a folder beside the list, which is renamed when they are
/// complete, so that the list never comes to the destination.
#[derive(Debug)]
pub(crate) struct UnfinishedSet {
    folder: PathBuf,
    /// The folder and those above it that did not exist before, the innermost first.
    new: Vec<PathBuf>,
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

/// Format of the folder.
pub(crate) const FORMAT: &str = "cranny-unfinished-set/2";

const LIST: &str = "unfinished.jsonl";

/// Folder of the members, beside the list.
const CONTENT: &str = "set";

impl UnfinishedSet {
    /// Opens the unfinished set of that identity beside `place`, or begins it.
    ///
    /// # Errors
    /// [`ScenarioError::Exists`] if the folder belongs to another program, [`ScenarioError::Unwritable`] also while another
    /// program makes the same set.
    pub fn open(place: &Path, identity: &str) -> Result<Self, ScenarioError> {
        let folder = folder_of(place, identity);
        let is_new = |path: &&Path| !path.as_os_str().is_empty() && fs::symlink_metadata(path).is_err();
        let new: Vec<PathBuf> = folder.ancestors().take_while(is_new).map(Path::to_owned).collect();
        let (file, known) = Self::list_in(&folder, identity).inspect_err(|_| remove_empty(&new))?;
        let list = List { file, is_empty: known.is_empty() };
        let set = Self { folder, new, known, list: Mutex::new(list) };
        match fs::create_dir_all(set.content()) {
            Ok(()) => Ok(set),
            Err(reason) => {
                let path = set.content();
                set.keep();
                Err(ScenarioError::Unwritable { path, reason })
            }
        }
    }

    /// Opens the list in the folder, or creates both. Nothing is created in a folder with other content.
    fn list_in(folder: &Path, identity: &str) -> Result<(File, BTreeMap<usize, Finished>), ScenarioError> {
        let foreign = || ScenarioError::Exists { path: folder.to_owned() };
        let unwritable = |reason| ScenarioError::Unwritable { path: folder.to_owned(), reason };
        let list = folder.join(LIST);
        fs::create_dir_all(folder).map_err(unwritable)?;
        // The name can be guessed: a link there may lead anywhere.
        if !fs::symlink_metadata(folder).map_err(unwritable)?.is_dir() {
            return Err(foreign());
        }
        let mut options = File::options();
        options.read(true).append(true);
        let mut file = match fs::symlink_metadata(&list) {
            Ok(found) if found.is_file() => options.open(&list),
            Err(_) if fs::read_dir(folder).map_err(unwritable)?.next().is_none() => {
                options.create_new(true).open(&list)
            }
            _ => return Err(foreign()),
        }
        .map_err(unwritable)?;
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
            None if fs::read_dir(folder).map_err(unwritable)?.count() == 1 => {
                file.set_len(0).map_err(unwritable)?;
                append(&mut file, &head).map_err(|reason| {
                    let _ = fs::remove_dir_all(folder);
                    unwritable(reason)
                })?;
            }
            _ => return Err(foreign()),
        }
        Ok((file, known))
    }

    /// Removes the list of a set that is complete: the program that made it was killed before.
    pub fn remove_rest(place: &Path, identity: &str) {
        let folder = folder_of(place, identity);
        if folder.join(LIST).exists()
            && !folder.join(CONTENT).exists()
            && let Ok(set) = Self::open(place, identity)
        {
            set.remove();
        }
    }

    /// Folder of the members.
    pub fn content(&self) -> PathBuf {
        self.folder.join(CONTENT)
    }

    /// Returns the member of that number if an earlier run finished it.
    pub fn finished(&self, number: usize) -> Option<Finished> {
        self.known.get(&number).cloned()
    }

    /// Returns the path of a member's folder, and removes what an earlier run left there unfinished.
    pub fn free_folder(&self, id: &str) -> Result<PathBuf, ScenarioError> {
        let path = self.content().join(id);
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

    /// Removes the folder, and those above it that were made for it.
    pub fn remove(self) {
        drop(self.list);
        // The same set, made again, uses the remainder.
        let _ = fs::remove_dir_all(&self.folder);
        remove_empty(&self.new);
    }

    /// Writes the index and moves the set to its destination.
    pub fn complete(self, place: &Path, index: &str) -> Result<(), ScenarioError> {
        write_into(&self.content(), "index.csv", index)?;
        let unwritable = |reason| ScenarioError::Unwritable { path: place.to_owned(), reason };
        put_in_place(&self.content(), place).map_err(unwritable)?;
        self.remove();
        Ok(())
    }
}

fn folder_of(place: &Path, identity: &str) -> PathBuf {
    // `a/b/` is treated as `a/b`.
    let mut name = place.components().as_path().as_os_str().to_owned();
    name.push(format!(".unfinished-{}", identity.get(..8).unwrap_or(identity)));
    PathBuf::from(name)
}

/// Removes empty folders, the innermost first.
fn remove_empty(folders: &[PathBuf]) {
    for folder in folders {
        // One that others use by now stays.
        let _ = fs::remove_dir(folder);
    }
}

/// Appends a line in one call, so that lines of several threads do not mix.
fn append(file: &mut File, row: &impl Serialize) -> io::Result<()> {
    let mut line = serde_json::to_vec(row)?;
    line.push(b'\n');
    file.write_all(&line)
}
