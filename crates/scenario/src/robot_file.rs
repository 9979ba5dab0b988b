use std::path::Path;
use std::sync::Arc;

use cranny_robot::{HandDescription, Robot, RobotError, RobotOptions, UrdfFile};

use crate::builtin_robot;

/// A robot from its URDF file. Its hand stands open, and its tip is the gripper frame, as `hand.yaml` beside the file
/// says, or what is known of the hand, unless `options` say otherwise.
pub(crate) fn load(path: &Path, options: &RobotOptions) -> Result<Arc<Robot>, RobotError> {
    UrdfFile::read(path)?.robot(&with_known_hands(options)?).map(Arc::new)
}

/// Hands that are known by the names of their joints, whoever wrote the URDF.
const KNOWN_HANDS: [(&str, &str); 1] = [("panda_mobile/hand.yaml", builtin_robot::HAND)];

pub(crate) fn with_known_hands(options: &RobotOptions) -> Result<RobotOptions, RobotError> {
    let mut options = options.clone();
    for (name, text) in KNOWN_HANDS {
        options.known_hands.push(HandDescription::parse(text, name)?);
    }
    Ok(options)
}
