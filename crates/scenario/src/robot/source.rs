use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_robot::{Robot, RobotFiles, RobotOptions};
use cranny_spatial::{Pose, Rotation, Vector};

use crate::ScenarioError;
use crate::layout::released_frame::FLOOR_M;
use crate::robot::builtin::{BUILTIN_ROBOTS, BuiltinRobot};
use crate::robot::file;
use crate::robot::in_folder::{ROBOT, quoted, write_robot};

/// Source of a scenario's robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RobotSource {
    /// Built-in robot, by name.
    Builtin(&'static str),
    /// Folder with a `robot.yaml`, or a URDF, without modifications elsewhere.
    Files(PathBuf),
    /// Robot of which a scenario file exempts these pairs of links.
    Exempting(Box<Self>, Vec<[String; 2]>),
    /// Robot that a scenario file modifies otherwise.
    Other,
}

impl RobotSource {
    /// Returns the source of the robot that a flag or file names.
    pub(crate) fn of(what: &Path) -> Self {
        match BuiltinRobot::of_path(what) {
            Some(robot) => Self::Builtin(robot.name),
            None => Self::Files(what.to_owned()),
        }
    }
}

/// Robot of a recipe, and its pose.
#[derive(Clone, Debug)]
pub struct RecipeRobot {
    /// The robot.
    pub robot: Arc<Robot>,
    /// Pose of its root in the scene.
    pub scene_from_root: Pose,
    /// Name in the scenario file.
    pub(crate) named: String,
    /// Files to be written with the scenario; `None` for a built-in robot.
    pub(crate) files: Option<Arc<RobotFiles>>,
    /// Pairs of links that the scenario file exempts.
    pub(crate) unchecked_pairs: Vec<[String; 2]>,
}

impl RecipeRobot {
    /// Loads the robot that `what` names (built in, a folder with a `robot.yaml`, a URDF), at the pose of the paper's robot.
    ///
    /// # Errors
    /// Any fault of its files.
    pub fn load(what: &Path) -> Result<Self, ScenarioError> {
        Self::load_with(what, &RobotOptions::default())
    }

    /// Loads the robot with other finger values or other options.
    ///
    /// # Errors
    /// As [`Self::load`], and for options that do not fit.
    pub fn load_with(what: &Path, options: &RobotOptions) -> Result<Self, ScenarioError> {
        Self::of(&RobotSource::of(what), file::load(what, options)?)
    }

    /// Returns the robot of the paper's scenarios.
    ///
    /// # Errors
    /// None unless the built-in files are broken.
    pub fn of_the_paper() -> Result<Self, ScenarioError> {
        Self::load(Path::new(BUILTIN_ROBOTS[0].name))
    }

    /// # Errors
    /// [`ScenarioError::OtherRobot`] for a robot that its files do not define completely.
    pub(crate) fn of(source: &RobotSource, robot: Arc<Robot>) -> Result<Self, ScenarioError> {
        let (named, files) = match source {
            RobotSource::Builtin(name) => ((*name).to_owned(), None),
            RobotSource::Files(path) => {
                (ROBOT.to_owned(), Some(Arc::new(RobotFiles::gather(path, None, &[])?)))
            }
            RobotSource::Exempting(source, unchecked_pairs) => {
                let unchecked_pairs = unchecked_pairs.clone();
                return Ok(Self { unchecked_pairs, ..Self::of(source, robot)? });
            }
            RobotSource::Other => return Err(ScenarioError::OtherRobot),
        };
        let named = match &files {
            Some(files) if !files.has_description() => format!("{ROBOT}/{}", files.urdf),
            _ => named,
        };
        let scene_from_root = scene_from_root(&robot);
        Ok(Self { scene_from_root, robot, named, files, unchecked_pairs: Vec::new() })
    }

    /// Writes the robot's files into a folder, for use by other programs, and returns the path of its URDF.
    ///
    /// # Errors
    /// [`ScenarioError::Unwritable`].
    pub fn write(&self, folder: &Path) -> Result<PathBuf, ScenarioError> {
        match (&self.files, BuiltinRobot::of_name(&self.named)) {
            (Some(files), _) => write_robot(folder, files).map(|()| folder.join(&files.urdf)),
            (None, Some(builtin)) => builtin.write(folder),
            (None, None) => Err(ScenarioError::OtherRobot),
        }
    }

    /// Returns the name of the URDF that [`Self::write`] writes.
    pub fn urdf_name(&self) -> String {
        self.files.as_ref().map_or_else(|| format!("{}.urdf", self.named), |files| files.urdf.clone())
    }

    /// Returns the robot for a scenario whose folder is beside that of the robot.
    pub(crate) fn in_set(&self) -> Self {
        let named = if self.files.is_some() { format!("../{}", self.named) } else { self.named.clone() };
        Self { named, files: None, ..self.clone() }
    }

    /// Returns the name in the scenario file, quoted for YAML if necessary.
    pub(crate) fn named_in_yaml(&self) -> String {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-/.".contains(c);
        if self.named.chars().all(is_plain) { self.named.clone() } else { quoted(&self.named) }
    }

    /// Returns the pose of the scene in the planning frame.
    pub(crate) fn planning_from_scene(&self) -> Pose {
        self.scene_from_root.inverse()
    }

    /// Returns the start configuration (m, rad; one per joint): that of its files, or else the permitted values nearest 0.
    pub fn start(&self) -> Vec<f64> {
        let near_zero = || self.robot.limits().iter().map(|limits| limits.clamp(0.0)).collect();
        self.robot.default_start().map_or_else(near_zero, <[f64]>::to_vec)
    }
}

/// Returns the pose of `robot` in the scene, as in the paper: 1 m along x, facing along y, with its own ground on the floor.
fn scene_from_root(robot: &Robot) -> Pose {
    let quarter_turn = Rotation::from_axis_angle(&Vector::z_axis(), std::f64::consts::FRAC_PI_2);
    Pose::from_parts(Vector::new(1.0, 0.0, -robot.floor_m().unwrap_or(FLOOR_M)).into(), quarter_turn)
}
