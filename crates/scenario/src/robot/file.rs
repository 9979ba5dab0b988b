use std::path::Path;
use std::sync::Arc;

use cranny_file::is_there;
use cranny_robot::{Robot, RobotOptions, UrdfFile};

use crate::ScenarioError;
use crate::robot::builtin::{BuiltinRobot, known_hands};

/// Loads the robot that `what` names: a built-in one, a folder with a `robot.yaml`, which takes precedence, or a URDF.
///
/// Unless `options` specify others, its hand is open and its tip is the gripper frame, as defined by `robot.yaml` beside the
/// URDF or by the known hands.
pub(crate) fn load(what: &Path, options: &RobotOptions) -> Result<Arc<Robot>, ScenarioError> {
    if let Some(builtin) = BuiltinRobot::of_path(what) {
        return Ok(builtin.robot(options)?);
    }
    if matches!(is_there(what), Ok(false)) {
        return Err(ScenarioError::NoRobot { what: what.to_owned(), known: BuiltinRobot::known() });
    }
    let options = RobotOptions { known_hands: known_hands()?, ..options.clone() };
    Ok(UrdfFile::read(what)?.robot(&options).map(Arc::new)?)
}
