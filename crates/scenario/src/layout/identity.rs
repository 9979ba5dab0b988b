use std::collections::BTreeMap;
use std::path::Path;

use sha2::{Digest as _, Sha256};

use crate::layout::archive;
use crate::layout::own;
use crate::layout::released;
use crate::{ScenarioError, built_in, scenario};

/// Identity of a scenario, independent of the location of its files.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Identity {
    /// Built-in id, or name of the folder.
    pub id: String,
    /// SHA-256 of names and contents of its files except hidden ones and plans, in hexadecimal. A built-in scenario, its folder
    /// and its packed folder have the same value.
    pub sha256: String,
    /// Size of these files, in bytes.
    pub bytes: u64,
}

impl Identity {
    /// Returns the identity of the scenario that `what` names, as accepted by [`Scenario::open`](crate::Scenario::open). Files
    /// outside its folder (a robot, an object library) do not contribute.
    ///
    /// # Errors
    /// [`ScenarioError`] if `what` names no scenario; the scenario is not checked for faults.
    pub fn of(what: &str) -> Result<Self, ScenarioError> {
        let path = Path::new(what);
        if let Some(entry) = built_in().find(|entry| entry.id == what) {
            let (scenario, grasps) = entry.files();
            let files = [(own::FILE, scenario), (own::GRASPS_FILE, grasps)];
            let contents = files.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec()));
            return Ok(Self::new(what.to_owned(), &contents.into()));
        }
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("zip")) {
            let id = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            return Ok(Self::new(id, &archive::contents_of_archive(path)?));
        }
        if path.join(own::FILE).is_file() || path.join(released::FILE).is_file() {
            return Ok(Self::new(scenario::id_of(path), &archive::contents_of_folder(path)?));
        }
        // The error is the one that opening it would give.
        crate::Scenario::open(what, &crate::OpenOptions::default()).map(|scenario| Self {
            id: scenario.id,
            sha256: String::new(),
            bytes: 0,
        })
    }

    fn new(id: String, contents: &BTreeMap<String, Vec<u8>>) -> Self {
        let bytes = contents.values().map(|content| content.len() as u64).sum();
        Self { id, sha256: hash(contents), bytes }
    }
}

/// Hashes name, length and content of every file, ordered by name.
fn hash(contents: &BTreeMap<String, Vec<u8>>) -> String {
    let mut digest = Sha256::new();
    for (name, content) in contents {
        digest.update(name.as_bytes());
        digest.update([0]);
        digest.update((content.len() as u64).to_le_bytes());
        digest.update(content);
    }
    archive::hexadecimal(&digest.finalize())
}
