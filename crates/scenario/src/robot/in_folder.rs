//! Robots of scenarios as files of the scenario folder.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use cranny_robot::RobotFiles;

use crate::ScenarioError;
use crate::files::atomic_file::write_into;
use crate::layout::own_file::ScenarioFile;

/// Folder of the robot's files within that of the scenario.
pub(crate) const ROBOT: &str = "robot";

/// Files of a robot, with the keys of a `scenario.yaml` that refer to them.
pub(crate) struct RobotInFolder {
    files: RobotFiles,
}

impl RobotInFolder {
    pub fn gather(urdf: &Path, srdf: Option<&Path>, packages: &[PathBuf]) -> Result<Self, ScenarioError> {
        Ok(Self { files: RobotFiles::gather(urdf, srdf, packages)? })
    }

    /// Gathers the robot of a scenario.
    pub fn of_scenario(file: &ScenarioFile, folder: &Path) -> Result<Self, ScenarioError> {
        let packages: Vec<PathBuf> = file.packages.iter().map(|package| folder.join(package)).collect();
        let srdf = file.srdf.as_ref().map(|srdf| folder.join(srdf));
        Self::gather(&folder.join(&file.robot.value), srdf.as_deref(), &packages)
    }

    /// Returns name and content of each file, relative to the scenario's folder.
    pub fn contents(&self) -> impl Iterator<Item = (String, &[u8])> {
        self.files.contents.iter().map(|(name, content)| (format!("{ROBOT}/{name}"), content.as_slice()))
    }

    /// Returns the path of the URDF, relative to the scenario's folder.
    pub fn urdf(&self) -> String {
        format!("{ROBOT}/{}", self.files.urdf)
    }

    /// Returns the text of a `scenario.yaml` that refers to these files; other lines are unchanged.
    pub fn named_in(&self, text: &str) -> String {
        let mut named = String::new();
        let mut is_left_out = false;
        for line in text.lines() {
            let is_key = |key: &str| line.strip_prefix(key).is_some_and(|rest| rest.starts_with(':'));
            let goes_on = line.starts_with([' ', '\t', '-']) && !line.trim().is_empty();
            is_left_out =
                if goes_on { is_left_out } else { ["robot", "srdf", "packages"].into_iter().any(is_key) };
            if is_left_out {
                if is_key("robot") {
                    let _ = writeln!(named, "robot: {}", quoted(&self.urdf()));
                    if let Some(srdf) = &self.files.srdf {
                        let _ = writeln!(named, "srdf: {}", quoted(&format!("{ROBOT}/{srdf}")));
                    }
                }
            } else {
                named += line;
                named.push('\n');
            }
        }
        named
    }
}

/// Returns a quoted YAML string with the given content.
pub(crate) fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Returns true if the robot's files are referenced by absolute paths.
pub(crate) fn is_named_by_place(file: &ScenarioFile, folder: &Path) -> bool {
    let mut named =
        file.srdf.iter().chain(&file.packages).map(PathBuf::as_path).chain([Path::new(&file.robot.value)]);
    let text = cranny_file::TEXT.text(&folder.join(&file.robot.value)).unwrap_or_default();
    named.any(Path::is_absolute)
        || ["file://", "filename=\"/", "filename='/"].iter().any(|place| text.contains(place))
}

/// Writes the files of a robot into its folder.
pub(crate) fn write_robot(folder: &Path, files: &RobotFiles) -> Result<(), ScenarioError> {
    for (name, content) in &files.contents {
        write_into(folder, name, content)?;
    }
    Ok(())
}
