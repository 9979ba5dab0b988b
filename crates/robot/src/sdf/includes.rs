use std::path::{Path, PathBuf};

use crate::RobotError;
use crate::description::mesh_path::{candidates, is_file_like};
use crate::description::text_source::read;
use crate::description::xml::{Element, XmlText};
use crate::model_file::unread_list::not_supported;

/// Environment variables with folders of models, separated as in `PATH`.
const VARIABLES: [&str; 3] = ["GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH", "SDF_PATH"];

/// Maximum length of all included files together, in bytes.
const MOST_BYTES: usize = 64 << 20;

/// Maximum number of files of a world.
const MOST_FILES: usize = 500;

/// Maximum number of files that include each other in a row; also ends a cycle.
pub(crate) const MOST_DEPTH: usize = 20;

/// Files of an SDF: the folders that are searched, and the number of files read.
pub(crate) struct ModelFolders {
    folders: Vec<PathBuf>,
    files: usize,
    bytes: usize,
}

impl ModelFolders {
    /// Returns the given folders, then those of the environment.
    pub(crate) fn new(given: &[PathBuf]) -> Self {
        let set = VARIABLES.iter().filter_map(std::env::var_os);
        let of_environment: Vec<PathBuf> =
            set.flat_map(|paths| std::env::split_paths(&paths).collect::<Vec<_>>()).collect();
        Self { folders: given.iter().cloned().chain(of_environment).collect(), files: 0, bytes: 0 }
    }

    /// Returns the text of an included model, and its path. The URI is that of its folder or file: `model://NAME`, a path, or
    /// `file://PATH`.
    pub(crate) fn included(
        &mut self,
        include: Element<'_>,
        folder: &Path,
    ) -> Result<(String, PathBuf), RobotError> {
        let uri = include.value("uri").unwrap_or_default().trim();
        if uri.is_empty() {
            let (at, owner) = (include.at(), include.title());
            return Err(RobotError::MissingElement { at, owner, element: "uri" });
        }
        if uri.contains("http://") || uri.contains("https://") {
            let what = format!("the address {uri} of an <include>");
            return Err(not_supported(include, what, "download the model and name its folder"));
        }
        self.files += 1;
        if self.files > MOST_FILES {
            let (at, actual) = (include.at(), self.files);
            return Err(RobotError::TooMany { at, what: "included files", most: MOST_FILES, actual });
        }
        let tried = candidates(uri, Some(folder), &self.folders);
        let Some(found) = tried.iter().find(|path| path.exists()) else {
            return Err(RobotError::ModelNotFound { at: include.at(), uri: uri.to_owned(), tried });
        };
        let path = if found.is_dir() { model_file(found)? } else { found.clone() };
        let text = read(cranny_file::TEXT, &path)?;
        self.bytes += text.len();
        if self.bytes > MOST_BYTES {
            let (what, most) = ("bytes in all included files", MOST_BYTES);
            return Err(RobotError::TooMany { at: include.at(), what, most, actual: self.bytes });
        }
        Ok((text, path))
    }

    /// Returns the path of a mesh if it is found, otherwise the name itself.
    pub(crate) fn mesh(&self, uri: &str, folder: &Path) -> String {
        let tried = candidates(uri.trim(), Some(folder), &self.folders);
        let found = tried.iter().find(|path| is_file_like(path));
        let found = found.and_then(|path| std::path::absolute(path).ok());
        found.map_or_else(|| uri.trim().to_owned(), |path| path.to_string_lossy().into_owned())
    }
}

/// Returns the SDF of a model folder: the one of the highest version that `model.config` names, or else `model.sdf`.
fn model_file(folder: &Path) -> Result<PathBuf, RobotError> {
    let config = folder.join("model.config");
    if !config.is_file() {
        return Ok(folder.join("model.sdf"));
    }
    let (text, name) = (read(cranny_file::TEXT, &config)?, config.display().to_string());
    let xml = XmlText::parse(&text, &name)?;
    let version = |element: &Element<'_>| {
        let parts = element.optional_text("version").unwrap_or_default().split('.');
        parts.map(|part| part.parse().unwrap_or(0)).collect::<Vec<u32>>()
    };
    let newest = xml.root().all("sdf").max_by_key(version).and_then(|sdf| sdf.own_text());
    Ok(folder.join(newest.unwrap_or("model.sdf")))
}
