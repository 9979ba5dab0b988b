use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_file::TEXT;
use cranny_robot::{Robot, RobotError, RobotOptions, Srdf, TextSource, UrdfFile};

use crate::ScenarioError;
use crate::files::yaml;
use crate::robot::builtin::BuiltinRobot;

/// Robot of `MoveIt` by its files: URDF, SRDF and limits. The robot of a problem follows from it and from a request, which
/// names the group of joints that move.
#[derive(Clone, Debug)]
pub struct MoveItRobot {
    name: String,
    urdf: Urdf,
    srdf: Srdf,
    srdf_text: Option<TextSource>,
    joint_limits: Option<(PathBuf, String)>,
    /// Robots that were built, the last one at the end, so that similar requests share data that depends on the robot alone.
    built: Vec<(RobotOptions, Arc<Robot>)>,
}

#[derive(Clone, Debug)]
enum Urdf {
    BuiltIn(&'static BuiltinRobot),
    File(UrdfFile),
}

/// Maximum number of built robots that are kept; a request builds one or two.
const MOST_BUILT: usize = 4;

impl MoveItRobot {
    /// Reads the files of a robot: a built-in one, a folder with a `robot.yaml`, or a URDF. Default of `srdf`: the file beside
    /// the URDF with its stem. A `joint_limits.yaml` is read beside URDF or SRDF, or in `config` beside it or its folder.
    ///
    /// # Errors
    /// [`ScenarioError`] for files that are missing or malformed. Meshes are read with the first request.
    pub fn open(robot: &Path, srdf: Option<&Path>) -> Result<Self, ScenarioError> {
        let found = BuiltinRobot::of_path(robot);
        if found.is_none() && matches!(cranny_file::is_there(robot), Ok(false)) {
            return Err(ScenarioError::NoRobot { what: robot.to_owned(), known: BuiltinRobot::known() });
        }
        Self::of_files(robot, srdf, [None; 2])
    }

    /// Reads the files of a robot; without an SRDF beside the URDF, `other_srdf` is read if it exists, and joint limits are also
    /// searched beside a scene.
    pub(crate) fn of_files(
        robot: &Path,
        srdf: Option<&Path>,
        [other_srdf, scene]: [Option<&Path>; 2],
    ) -> Result<Self, ScenarioError> {
        let urdf = match BuiltinRobot::of_path(robot) {
            Some(builtin) => Urdf::BuiltIn(builtin),
            None => Urdf::File(UrdfFile::read(robot)?),
        };
        let urdf_path = match &urdf {
            Urdf::BuiltIn(_) => None,
            Urdf::File(file) => Some(file.path()),
        };
        let beside = urdf_path.map(|path| path.with_extension("srdf")).filter(|path| path.is_file());
        let srdf_path = srdf.or(beside.as_deref()).or(other_srdf);
        let srdf_text = match (srdf_path, &urdf) {
            (Some(path), _) => Some((path.display().to_string(), yaml::text(TEXT, path)?)),
            (None, Urdf::BuiltIn(builtin)) => Some(builtin.srdf()),
            (None, Urdf::File(_)) => None,
        };
        let parsed = srdf_text.as_ref().map(|(name, text)| Srdf::parse(text, name)).transpose()?;
        let limits = joint_limits([urdf_path, srdf_path, scene]);
        let name = match &urdf {
            Urdf::BuiltIn(builtin) => builtin.name.to_owned(),
            Urdf::File(file) => file.robot_name()?,
        };
        Ok(Self {
            name,
            srdf: parsed.unwrap_or_default(),
            srdf_text: srdf_text.map(|(name, text)| TextSource::Text { name, text }),
            joint_limits: limits.map(|path| yaml::text(TEXT, &path).map(|text| (path, text))).transpose()?,
            urdf,
            built: Vec::new(),
        })
    }

    /// Name of the robot.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// SRDF; empty if there is none.
    pub fn srdf(&self) -> &Srdf {
        &self.srdf
    }

    /// Path of the joint limits, if there are any.
    pub(crate) fn joint_limits(&self) -> Option<&Path> {
        self.joint_limits.as_ref().map(|(path, _)| path.as_path())
    }

    /// Builds the robot with SRDF and joint limits from the files, or returns it if it was built before.
    pub(crate) fn build(&mut self, options: &RobotOptions) -> Result<Arc<Robot>, RobotError> {
        if let Some((_, robot)) = self.built.iter().find(|(known, _)| known == options) {
            return Ok(robot.clone());
        }
        let limits = self.joint_limits.clone();
        let whole = RobotOptions {
            srdf: self.srdf_text.clone(),
            joint_limits: limits
                .map(|(path, text)| TextSource::Text { name: path.display().to_string(), text }),
            ..options.clone()
        };
        let robot = match &self.urdf {
            Urdf::BuiltIn(builtin) => builtin.robot(&whole)?,
            Urdf::File(file) => Arc::new(file.robot(&whole)?),
        };
        if self.built.len() == MOST_BUILT {
            self.built.remove(0);
        }
        self.built.push((options.clone(), robot.clone()));
        Ok(robot)
    }
}

/// Returns the path of `MoveIt`'s joint limits: beside one of these files, or in `config` beside it or its folder.
fn joint_limits(files: [Option<&Path>; 3]) -> Option<PathBuf> {
    let folders = files.into_iter().flatten().map(|file| file.parent().unwrap_or(Path::new("")));
    let mut tried = folders.flat_map(|folder| {
        ["", "config", "../config"].map(|between| folder.join(between).join("joint_limits.yaml"))
    });
    tried.find(|file| file.is_file())
}
