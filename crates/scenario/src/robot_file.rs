use std::path::Path;
use std::sync::Arc;

use cranny_robot::{Robot, RobotError, RobotOptions, UrdfFile};

/// Where the fingers of a Panda's gripper stand when it is open, in metres each: their upper limit.
const OPEN_FINGER_M: f64 = 0.04;

const PANDA_FINGERS: [&str; 2] = ["panda_finger_joint1", "panda_finger_joint2"];

/// The frame between the finger pads of the released Panda, and the tip of any robot that has it.
const PANDA_TIP: &str = "panda_grasptarget";

/// A robot from its URDF file. A Panda's fingers stand open, and its tip lies between them, unless `options`
/// say otherwise.
pub(crate) fn load(path: &Path, options: &RobotOptions) -> Result<Arc<Robot>, RobotError> {
    let urdf = UrdfFile::read(path)?;
    with_open_hand(options, |options| urdf.robot(options)).map(Arc::new)
}

/// Builds a robot with an open hand. The names of a Panda that the robot does not have are left out one by
/// one: a wrong name is noticed before any mesh is read, so this costs next to nothing.
pub(crate) fn with_open_hand(
    options: &RobotOptions,
    build: impl Fn(&RobotOptions) -> Result<Robot, RobotError>,
) -> Result<Robot, RobotError> {
    let mut wished = options.clone();
    wished.tip.get_or_insert_with(|| PANDA_TIP.to_owned());
    for finger in PANDA_FINGERS {
        wished.fixed.entry(finger.to_owned()).or_insert(OPEN_FINGER_M);
    }
    loop {
        match build(&wished) {
            Err(RobotError::UnknownName { name, .. })
                if options.tip.is_none() && wished.tip.as_deref() == Some(name.as_str()) =>
            {
                wished.tip = None;
            }
            Err(RobotError::UnknownName { name, .. })
                if !options.fixed.contains_key(&name) && wished.fixed.contains_key(&name) =>
            {
                wished.fixed.remove(&name);
            }
            result => return result,
        }
    }
}
