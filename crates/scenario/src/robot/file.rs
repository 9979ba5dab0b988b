use std::path::Path;
use std::sync::Arc;

use cranny_robot::{Robot, RobotError, RobotOptions, UrdfFile};

use crate::robot::builtin::{BuiltinRobot, known_hands};

/// The robot that `what` names: a built-in one, a folder with a `robot.yaml`, or a URDF. A robot's folder
/// goes before a built-in one of the same name.
///
/// Its hand stands open, and its tip is the gripper frame, as `robot.yaml` beside the URDF says, or what is known of the
/// hand, unless `options` say otherwise.
pub(crate) fn load(what: &Path, options: &RobotOptions) -> Result<Arc<Robot>, RobotError> {
    if let Some(builtin) = BuiltinRobot::of_path(what) {
        return builtin.robot(options);
    }
    let options = RobotOptions { known_hands: known_hands()?, ..options.clone() };
    UrdfFile::read(what)?.robot(&options).map(Arc::new)
}
