use std::collections::BTreeMap;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use cranny_file::FileFault;

use crate::description::robot_description::{DESCRIPTION, LIMITS};
use crate::description::urdf_text::replaced;
use crate::description::xml::{XmlText, known_prefixes};
use crate::{ModelText, ModelUse, RobotDescription, RobotError, description::mesh_path};

/// Collected files of a robot: URDF, SRDF, limits and meshes under names in one folder; the URDF refers to its meshes without
/// any package.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotFiles {
    /// Content by file name, with slashes.
    pub contents: BTreeMap<String, Vec<u8>>,
    /// Name of the URDF.
    pub urdf: String,
    /// Name of the SRDF, if there is one.
    pub srdf: Option<String>,
}

/// Folder of the meshes.
const MESHES: &str = "meshes";

impl RobotFiles {
    /// Reads the files of the robot at `robot`, a URDF, MJCF or SDF, or a folder with a `robot.yaml`: the SRDF given, or else the one beside
    /// it, `limits.yaml` and `robot.yaml` beside it, and every collision and visual mesh named in it; `package://` as in
    /// [`RobotOptions::packages`](crate::RobotOptions::packages). A missing visual mesh is omitted. Files that a mesh file
    /// refers to, such as textures, are not included.
    ///
    /// # Errors
    /// [`RobotError::Unreadable`], also for more than a GiB of meshes, [`RobotError::MeshNotFound`], and the errors of parsing the URDF.
    pub fn gather(robot: &Path, srdf: Option<&Path>, packages: &[PathBuf]) -> Result<Self, RobotError> {
        let urdf = &RobotDescription::urdf_at(robot)?;
        let text = cranny_file::TEXT
            .text(urdf)
            .map_err(|reason| RobotError::Unreadable { path: urdf.to_owned(), reason })?;
        let model = ModelText::of(text, urdf, ModelUse::Robot, packages)?;
        let is_named = urdf.with_file_name(DESCRIPTION).is_file() || model.srdf.is_none();
        let written = if is_named { urdf.clone() } else { urdf.with_extension("urdf") };
        let mut files = Self::of_text(&model.urdf, &written, packages)?;
        let name_of = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let beside = urdf.with_extension("srdf");
        let srdf = srdf.map(Path::to_owned).or_else(|| beside.is_file().then_some(beside));
        let others = [LIMITS, DESCRIPTION].map(|name| urdf.with_file_name(name)).into_iter();
        for extra in srdf.iter().cloned().chain(others.filter(|path| path.is_file())) {
            files.contents.insert(name_of(&extra), bytes_of(&extra)?);
        }
        files.srdf = srdf.as_deref().map(name_of);
        // What a URDF cannot express is in files of its own.
        if let (None, Some(pairs)) = (&files.srdf, model.srdf) {
            let name = name_of(&urdf.with_extension("srdf"));
            files.contents.insert(name.clone(), pairs.into_bytes());
            files.srdf = Some(name);
        }
        if let Some(limits) = model.limits {
            files.contents.entry(LIMITS.to_owned()).or_insert_with(|| limits.into_bytes());
        }
        Ok(files)
    }

    /// Collects URDF and meshes only; `text` is that of the URDF at `urdf`, possibly modified.
    ///
    /// # Errors
    /// As [`Self::gather`].
    pub fn of_text(text: &str, urdf: &Path, packages: &[PathBuf]) -> Result<Self, RobotError> {
        let mut contents = BTreeMap::new();
        // By canonical path: a mesh may have as many spellings as there are links.
        let mut names: BTreeMap<PathBuf, String> = BTreeMap::new();
        let mut places = Vec::new();
        let mut total = 0;
        // Of several meshes with one file name, the last keeps its name.
        for mesh in mesh_names(text, urdf)?.into_iter().rev() {
            let tried = mesh_path::candidates(&mesh.file, urdf.parent(), packages);
            let Some(path) = tried.iter().find(|path| mesh_path::is_file_like(path)) else {
                if mesh.is_for_looks {
                    continue;
                }
                return Err(mesh.not_found(tried));
            };
            let unreadable = |reason| RobotError::Unreadable { path: path.clone(), reason };
            let file = std::fs::canonicalize(path).map_err(unreadable)?;
            if !names.contains_key(&file) {
                let name = free_name(path, &contents);
                let bytes = bytes_of(path)?;
                total += bytes.len() as u64;
                check_total(total).map_err(unreadable)?;
                contents.insert(name.clone(), bytes);
                names.insert(file.clone(), name);
            }
            places.push((mesh.place, file));
        }
        let new_names = places.iter().rev().map(|(place, path)| (place.clone(), &*names[path]));
        let text = replaced(text, new_names);
        let name = urdf.file_name().unwrap_or_default().to_string_lossy().into_owned();
        contents.insert(name.clone(), text.into_bytes());
        Ok(Self { contents, urdf: name, srdf: None })
    }
}

/// Checks the size of all meshes of a robot, in bytes: they are kept together.
fn check_total(size: u64) -> io::Result<()> {
    const MOST: u64 = 1 << 30;
    if size <= MOST || cranny_file::are_limits_lifted() {
        return Ok(());
    }
    Err(FileFault::TooLarge { what: "a robot with its meshes", size: Some(size), most: MOST }.into())
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, RobotError> {
    let unreadable = |reason| RobotError::Unreadable { path: path.to_owned(), reason };
    cranny_file::MESH.bytes(path).map_err(unreadable)
}

impl RobotFiles {
    /// Returns true if the files include a `robot.yaml`, so that their folder names the robot.
    pub fn has_description(&self) -> bool {
        self.contents.contains_key(DESCRIPTION)
    }
}

/// Mesh name in a URDF.
pub(crate) struct MeshName {
    pub(crate) file: String,
    /// Position of the name in the text.
    pub(crate) place: Range<usize>,
    link: String,
    at: crate::Location,
    is_for_looks: bool,
}

impl MeshName {
    fn not_found(self, tried: Vec<PathBuf>) -> RobotError {
        RobotError::MeshNotFound { at: self.at, link: self.link, mesh: self.file, tried }
    }
}

/// Returns the meshes named in a URDF, in the order of the text.
pub(crate) fn mesh_names(text: &str, urdf: &Path) -> Result<Vec<MeshName>, RobotError> {
    let file = urdf.display().to_string();
    let text = known_prefixes(text);
    let xml = XmlText::parse(&text, &file)?;
    let mut names = Vec::new();
    for link in xml.robot()?.all("link") {
        for (tag, is_for_looks) in [("collision", false), ("visual", true)] {
            let geometries = link.all(tag).filter_map(|body| body.first("geometry"));
            for mesh in geometries.filter_map(|geometry| geometry.first("mesh")) {
                let Some((file, place)) = mesh.text_and_place("filename") else { continue };
                let link = link.optional_text("name").unwrap_or_default().to_owned();
                names.push(MeshName { file: file.to_owned(), place, link, at: mesh.at(), is_for_looks });
            }
        }
    }
    names.sort_by_key(|name| name.place.start);
    Ok(names)
}

/// Returns an unused name for the mesh.
fn free_name(path: &Path, taken: &BTreeMap<String, Vec<u8>>) -> String {
    let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
    let stem: String = part(path.file_stem()).chars().map(|c| if is_plain(c) { c } else { '_' }).collect();
    let ending = part(path.extension());
    let with = |suffix: String| format!("{MESHES}/{stem}{suffix}.{ending}");
    let numbered = (2..).map(|number: u32| with(format!("-{number}")));
    std::iter::once(with(String::new()))
        .chain(numbered)
        .find(|name| !taken.contains_key(name))
        .unwrap_or_default()
}
