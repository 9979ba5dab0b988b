//! Scenarios in one file: a zip archive of the folder with `manifest.json`, which contains author, licence and citation and the
//! SHA-256 of every other file.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};

use cranny_file::{ARCHIVE, MESH, TEXT, excerpt};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::files::yaml;
use crate::layout::archive_contents as unpacked;
use crate::layout::archive_contents::fault;
use crate::layout::own;
use crate::layout::own_file::{AboutEntry, ScenarioFile};
use crate::robot::in_folder::{RobotInFolder, is_named_by_place};
use crate::{
    BuiltinRobot, OpenOptions, Scenario, ScenarioError, StagingFolder, scenario, write_whole_file,
    write_whole_folder,
};

const MANIFEST: &str = "manifest.json";

/// Version of the manifest that is written and read.
const VERSION: u32 = 1;

/// Author, licence and citation of a scenario; missing entries are taken from `about` of `scenario.yaml`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Credits {
    /// Author of the scenario.
    pub author: Option<String>,
    /// SPDX expression, such as `CC-BY-4.0`.
    pub licence: Option<String>,
    /// Requested citation.
    pub citation: Option<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    cranny_scenario: u32,
    id: String,
    author: Option<String>,
    licence: Option<String>,
    citation: Option<String>,
    /// SHA-256 by path.
    files: BTreeMap<String, String>,
}

/// Packs the folder of a scenario in Cranny's layout: every file in it except hidden ones and plans. The archive is
/// reproducible: the same folder gives the same bytes. A robot from outside the folder is included in `robot/`, and the packed
/// `scenario.yaml` refers to it. The archive is opened as a test before it is written, so it never depends on other files.
///
/// # Errors
/// [`ScenarioError`] for a folder that does not open, also by itself; [`ScenarioError::Content`] for a link in it.
pub fn pack(folder: &Path, archive: &Path, credits: &Credits) -> Result<Vec<String>, ScenarioError> {
    let path = folder.join(own::FILE);
    if !path.is_file() {
        return Err(ScenarioError::NoScenarioFile { folder: folder.to_owned() });
    }
    // Faults of the scenario itself are reported for the original files.
    own::open(folder, &OpenOptions::default())?;
    let file: ScenarioFile = yaml::read(&path)?;
    let id = scenario::id_of(folder);
    let mut contents = BTreeMap::new();
    // An archive that lies in the folder is no part of it.
    collect(folder, "", fs::canonicalize(archive).ok().as_deref(), &mut contents)?;
    let is_own_robot = BuiltinRobot::of_name(&file.robot.value).is_none();
    if is_own_robot && (is_named_by_place(&file, folder) || open_alone(&id, &contents).is_err()) {
        bring_robot(&file, folder, &mut contents)?;
    }
    unpacked::check_names(contents.keys().map(String::as_str)).map_err(|problem| fault(folder, problem))?;
    let alone = Unpacked::of(&id, &contents)?;
    let inside = alone.folder();
    Scenario::open(&inside.to_string_lossy(), &OpenOptions::default()).map_err(|reason| {
        // The reader knows no temporary folder.
        let reason = reason.to_string().replace(&format!("{}/", inside.display()), "");
        let problem = "the scenario does not open by itself: what it names, such as objects and meshes, must lie in its folder, and \
                       in it the reader finds";
        fault(folder, format!("{problem} this: {reason}"))
    })?;
    let about = file.about.unwrap_or_default();
    let AboutEntry { author, licence, citation, .. } = about;
    let manifest = Manifest {
        cranny_scenario: VERSION,
        author: credits.author.clone().or(author),
        licence: credits.licence.clone().or(licence),
        citation: credits.citation.clone().or(citation),
        files: contents.iter().map(|(name, bytes)| (name.clone(), checksum(bytes))).collect(),
        id,
    };
    let bytes = zipped(&manifest, &contents).map_err(|reason| fault(archive, reason.to_string()))?;
    // An archive that could not be unpacked again is not written.
    let whole = contents.values().map(|content| content.len() as u64).sum();
    unpacked::check_size(whole, bytes.len() as u64).map_err(|problem| fault(archive, problem))?;
    write_whole_file(archive, &bytes)?;
    Ok(contents.into_keys().collect())
}

/// Unpacks an archive into `folder`, which must not exist or must be empty, and verifies the checksums.
///
/// # Errors
/// [`ScenarioError::Content`] for a broken archive, a path outside the folder, or a wrong checksum; [`ScenarioError::Exists`].
pub fn unpack(archive: &Path, folder: &Path) -> Result<Vec<String>, ScenarioError> {
    let contents = read(archive, &bytes_of(archive)?)?;
    write_whole_folder(folder, |folder| write_all(folder, &contents))?;
    Ok(contents.into_keys().collect())
}

/// Checks that the files form a complete scenario in a folder of their own.
fn open_alone(id: &str, contents: &BTreeMap<String, Vec<u8>>) -> Result<(), ScenarioError> {
    let unpacked = Unpacked::of(id, contents)?;
    Scenario::open(&unpacked.folder().to_string_lossy(), &OpenOptions::default()).map(|_| ())
}

/// Adds the files of the robot to those of the scenario, and makes `scenario.yaml` refer to them.
fn bring_robot(
    file: &ScenarioFile,
    folder: &Path,
    contents: &mut BTreeMap<String, Vec<u8>>,
) -> Result<(), ScenarioError> {
    let robot = RobotInFolder::of_scenario(file, folder)?;
    let text = robot.named_in(&yaml::text(TEXT, &folder.join(own::FILE))?);
    contents.insert(own::FILE.to_owned(), text.into_bytes());
    for (name, content) in robot.contents() {
        if contents.insert(name.clone(), content.to_vec()).is_some_and(|there| there != content) {
            let problem = format!("'{name}' is there already, but is not the robot that scenario.yaml names");
            return Err(fault(folder, problem));
        }
    }
    Ok(())
}

/// Temporary folder with the content of an archive. It is removed on drop, or by a later program if this one is killed.
pub(crate) struct Unpacked {
    root: StagingFolder,
    id: String,
}

impl Unpacked {
    pub fn open(archive: &Path) -> Result<Self, ScenarioError> {
        // The stem of `...zip` is `..`, which names no folder of its own.
        let stem = archive.file_stem().filter(|stem| Path::new(stem).file_name().is_some());
        Self::of(&stem.unwrap_or_default().to_string_lossy(), &contents_of_archive(archive)?)
    }

    fn of(id: &str, contents: &BTreeMap<String, Vec<u8>>) -> Result<Self, ScenarioError> {
        let unwritable = |reason| ScenarioError::Unwritable { path: std::env::temp_dir(), reason };
        let root = StagingFolder::temporary().map_err(unwritable)?;
        let unpacked = Self { root, id: id.to_owned() };
        write_all(&unpacked.folder(), contents)?;
        Ok(unpacked)
    }

    pub fn folder(&self) -> PathBuf {
        // Beside the mark of the staging folder, whose name an archive may have.
        self.root.path().join("unpacked").join(&self.id)
    }
}

fn bytes_of(archive: &Path) -> Result<Vec<u8>, ScenarioError> {
    ARCHIVE.bytes(archive).map_err(|reason| ScenarioError::Unreadable { path: archive.to_owned(), reason })
}

fn checksum(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// Returns two hexadecimal digits per byte.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    let mut text = String::new();
    for byte in bytes {
        let _ = write!(text, "{byte:02x}");
    }
    text
}

/// Returns the files of a packed scenario by path, with verified checksums.
pub(crate) fn contents_of_archive(archive: &Path) -> Result<BTreeMap<String, Vec<u8>>, ScenarioError> {
    read(archive, &bytes_of(archive)?)
}

/// Returns the files of a folder by path, as they would be packed.
pub(crate) fn contents_of_folder(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>, ScenarioError> {
    let mut contents = BTreeMap::new();
    collect(folder, "", None, &mut contents)?;
    Ok(contents)
}

/// Collects the files below `folder` by path, with slashes.
fn collect(
    folder: &Path,
    prefix: &str,
    besides: Option<&Path>,
    contents: &mut BTreeMap<String, Vec<u8>>,
) -> Result<(), ScenarioError> {
    let unreadable = |path: &Path, reason| ScenarioError::Unreadable { path: path.to_owned(), reason };
    for entry in fs::read_dir(folder).map_err(|reason| unreadable(folder, reason))? {
        let entry = entry.map_err(|reason| unreadable(folder, reason))?;
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        let kind = entry.file_type().map_err(|reason| unreadable(&path, reason))?;
        if name.starts_with('.') || name.ends_with(".plan.json") || name == MANIFEST {
            continue;
        }
        if kind.is_symlink() {
            return Err(fault(&path, "is a link, and what it leads to may be outside the folder"));
        }
        if kind.is_dir() {
            collect(&path, &format!("{prefix}{name}/"), besides, contents)?;
        } else if besides.is_none_or(|besides| fs::canonicalize(&path).is_ok_and(|path| path != besides)) {
            let bytes = MESH.bytes(&path).map_err(|reason| unreadable(&path, reason))?;
            contents.insert(format!("{prefix}{name}"), bytes);
        }
    }
    Ok(())
}

fn zipped(manifest: &Manifest, contents: &BTreeMap<String, Vec<u8>>) -> zip::result::ZipResult<Vec<u8>> {
    // All files have the same time stamp; otherwise the same folder would not give the same bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    archive.start_file(MANIFEST, options)?;
    let text = serde_json::to_string_pretty(manifest).map_err(std::io::Error::other)?;
    archive.write_all(text.as_bytes())?;
    for (name, bytes) in contents {
        archive.start_file(name.as_str(), options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}

/// Returns the files of an archive except the manifest, which they must agree with.
fn read(path: &Path, bytes: &[u8]) -> Result<BTreeMap<String, Vec<u8>>, ScenarioError> {
    let mut contents = unpacked::contents(path, bytes)?;
    let Some(manifest) = contents.remove(MANIFEST) else {
        return Err(fault(path, format!("has no {MANIFEST}, so it is no packed scenario")));
    };
    let manifest: Manifest = cranny_file::json(&manifest)
        .map_err(|reason| fault(path, format!("{MANIFEST}, line {}: {reason}", reason.line)))?;
    if manifest.cranny_scenario != VERSION {
        return Err(fault(path, format!("is of version {}, not {VERSION}", manifest.cranny_scenario)));
    }
    for (name, sum) in &manifest.files {
        match contents.get(name) {
            None => return Err(fault(path, format!("'{}' is missing", excerpt(name)))),
            Some(content) if checksum(content) != *sum => {
                return Err(fault(path, format!("'{name}' is not what was packed: its checksum differs")));
            }
            Some(_) => {}
        }
    }
    if let Some(name) = contents.keys().find(|name| !manifest.files.contains_key(*name)) {
        return Err(fault(path, format!("'{name}' is not in {MANIFEST}")));
    }
    Ok(contents)
}

fn write_all(folder: &Path, contents: &BTreeMap<String, Vec<u8>>) -> Result<(), ScenarioError> {
    for (name, content) in contents {
        let path = folder.join(name);
        let write = || -> std::io::Result<()> {
            if let Some(parent) = path.parent() {
                fs::create_dir_all(parent)?;
            }
            File::create(&path)?.write_all(content)
        };
        write().map_err(|reason| ScenarioError::Unwritable { path: path.clone(), reason })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The folder of a killed program stayed, and an archive named `...zip` was unpacked beside its folder.
    #[test]
    fn an_archive_is_unpacked_into_a_folder_that_others_can_remove() {
        let root = tempfile::tempdir().unwrap();
        let files = BTreeMap::from([("a/b".to_owned(), b"x".to_vec())]);
        let manifest = Manifest {
            cranny_scenario: VERSION,
            id: String::new(),
            author: None,
            licence: None,
            citation: None,
            files: files.iter().map(|(name, bytes)| (name.clone(), checksum(bytes))).collect(),
        };
        for name in ["mark.zip", "...zip"] {
            let archive = root.path().join(name);
            fs::write(&archive, zipped(&manifest, &files).unwrap()).unwrap();
            let unpacked = Unpacked::open(&archive).unwrap();
            let folder = fs::canonicalize(unpacked.folder()).unwrap();
            let staging = fs::canonicalize(unpacked.root.path()).unwrap();
            assert!(folder.starts_with(staging.join("unpacked")) && folder.join("a/b").is_file(), "{name}");
            assert!(staging.join("mark").is_file());
            drop(unpacked);
            assert!(!staging.exists());
        }
    }
}
