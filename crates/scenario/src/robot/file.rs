use std::path::Path;
use std::sync::Arc;

use cranny_file::is_there;
use cranny_robot::{Robot, RobotOptions, UrdfFile};

use crate::ScenarioError;
use crate::robot::builtin::{BuiltinRobot, known_hands};

/// The robot that `what` names: a built-in one, a folder with a `robot.yaml`, or a URDF. A robot's folder
/// goes before a built-in one of the same name.
///
/// Its hand stands open, and its tip is the gripper frame, as `robot.yaml` beside the URDF says, or what is known of the
/// hand, unless `options` say otherwise.
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
