use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_robot::{Robot, RobotFiles, RobotOptions};
use cranny_spatial::{Pose, Rotation, Vector};

use crate::ScenarioError;
use crate::layout::released_frame::FLOOR_M;
use crate::robot::builtin::{BUILTIN_ROBOTS, BuiltinRobot};
use crate::robot::file;
use crate::robot::in_folder::{ROBOT, quoted, write_robot};

/// Where a scenario's robot comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RobotSource {
    /// A built-in one, by its name.
    Builtin(&'static str),
    /// A folder with a `robot.yaml`, or a URDF, and nothing is said of it elsewhere.
    Files(PathBuf),
    /// A robot of which a scenario's file says more than its own.
    Other,
}

impl RobotSource {
    /// Of what a flag or a file calls a robot.
    pub(crate) fn of(what: &Path) -> Self {
        match BuiltinRobot::of_path(what) {
            Some(robot) => Self::Builtin(robot.name),
            None => Self::Files(what.to_owned()),
        }
    }
}

/// The robot of a recipe, and where it stands.
#[derive(Clone, Debug)]
pub struct RecipeRobot {
    /// The robot.
    pub robot: Arc<Robot>,
    /// Where its root is.
    pub scene_from_root: Pose,
    /// What the scenario's file calls it.
    pub(crate) named: String,
    /// Its files, to be written with the scenario; of a built-in robot none.
    pub(crate) files: Option<Arc<RobotFiles>>,
}

impl RecipeRobot {
    /// The robot that `what` names (a built-in one, a folder with a `robot.yaml`, a URDF), where the paper has its own.
    ///
    /// # Errors
    /// Whatever is wrong with its files.
    pub fn load(what: &Path) -> Result<Self, ScenarioError> {
        Self::load_with(what, &RobotOptions::default())
    }

    /// The same with other values of the fingers, or whatever else the options say.
    ///
    /// # Errors
    /// As [`Self::load`], and for options that do not fit.
    pub fn load_with(what: &Path, options: &RobotOptions) -> Result<Self, ScenarioError> {
        Self::of(&RobotSource::of(what), file::load(what, options)?)
    }

    /// The robot of the paper's scenarios.
    ///
    /// # Errors
    /// None on a sound build.
    pub fn of_the_paper() -> Result<Self, ScenarioError> {
        Self::load(Path::new(BUILTIN_ROBOTS[0].name))
    }

    /// # Errors
    /// [`ScenarioError::OtherRobot`] for one whose files do not say all of it.
    pub(crate) fn of(source: &RobotSource, robot: Arc<Robot>) -> Result<Self, ScenarioError> {
        let (named, files) = match source {
            RobotSource::Builtin(name) => ((*name).to_owned(), None),
            RobotSource::Files(path) => {
                (ROBOT.to_owned(), Some(Arc::new(RobotFiles::gather(path, None, &[])?)))
            }
            RobotSource::Other => {
                return Err(ScenarioError::OtherRobot { joints: robot.joint_names().join(", ") });
            }
        };
        let named = match &files {
            Some(files) if !files.has_description() => format!("{ROBOT}/{}", files.urdf),
            _ => named,
        };
        Ok(Self { scene_from_root: scene_from_root(&robot), robot, named, files })
    }

    /// Writes its files into a folder, for programs of others; the path of its URDF.
    ///
    /// # Errors
    /// [`ScenarioError::Unwritable`].
    pub fn write(&self, folder: &Path) -> Result<PathBuf, ScenarioError> {
        match (&self.files, BuiltinRobot::of_name(&self.named)) {
            (Some(files), _) => write_robot(folder, files).map(|()| folder.join(&files.urdf)),
            (None, Some(builtin)) => builtin.write(folder),
            (None, None) => Err(ScenarioError::OtherRobot { joints: self.robot.joint_names().join(", ") }),
        }
    }

    /// The name of the URDF that [`Self::write`] writes.
    pub fn urdf_name(&self) -> String {
        self.files.as_ref().map_or_else(|| format!("{}.urdf", self.named), |files| files.urdf.clone())
    }

    /// The same for a scenario whose folder lies beside that of the robot.
    pub(crate) fn in_set(&self) -> Self {
        let named = if self.files.is_some() { format!("../{}", self.named) } else { self.named.clone() };
        Self { named, files: None, ..self.clone() }
    }

    /// What the scenario's file calls it, as YAML reads it back.
    pub(crate) fn named_in_yaml(&self) -> String {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-/.".contains(c);
        if self.named.chars().all(is_plain) { self.named.clone() } else { quoted(&self.named) }
    }

    /// The scene in the planning frame.
    pub(crate) fn planning_from_scene(&self) -> Pose {
        self.scene_from_root.inverse()
    }

    /// The configuration (m, rad; one per joint) in which it starts: that of its files, else each joint as near to 0
    /// as it can.
    pub fn start(&self) -> Vec<f64> {
        let near_zero = || self.robot.limits().iter().map(|limits| limits.clamp(0.0)).collect();
        self.robot.default_start().map_or_else(near_zero, <[f64]>::to_vec)
    }
}

/// Where the paper has its robot in the scene, 1 m along x and looking along y; each with its own ground on the floor.
fn scene_from_root(robot: &Robot) -> Pose {
    let quarter_turn = Rotation::from_axis_angle(&Vector::z_axis(), std::f64::consts::FRAC_PI_2);
    Pose::from_parts(Vector::new(1.0, 0.0, -robot.floor_m().unwrap_or(FLOOR_M)).into(), quarter_turn)
}
