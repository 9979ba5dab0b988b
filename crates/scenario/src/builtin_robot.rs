use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_plan::Hand;
use cranny_robot::{Robot, RobotError, RobotOptions, TextSource};

use crate::{ScenarioError, hand, robot_file};

/// What scenario files call the built-in robot.
pub(crate) const PANDA_MOBILE: &str = "panda_mobile";

/// The built-in robot: a Panda with its hand, fingers open, on a holonomic base; nine joints. It needs no
/// file.
///
/// # Errors
/// None on a sound build: [`RobotError`] would mean that the built-in files are broken, which a test
/// excludes.
pub fn panda_mobile() -> Result<Arc<Robot>, RobotError> {
    panda_mobile_with(&RobotOptions::default())
}

/// The hand of the built-in robot, with open fingers.
///
/// # Errors
/// As [`panda_mobile`].
pub fn panda_hand() -> Result<Hand, RobotError> {
    let robot = panda_mobile()?;
    Ok(Hand::of_robot(&robot, &hand::hand_links(&robot)))
}

/// Writes the files of the built-in robot into `folder`, for programs of others, and returns the path of the
/// URDF; SRDF and limits lie beside it.
///
/// # Errors
/// [`ScenarioError::Unwritable`].
pub fn write_panda_mobile(folder: &Path) -> Result<PathBuf, ScenarioError> {
    let unwritable = |path: &Path, reason| ScenarioError::Unwritable { path: path.to_owned(), reason };
    fs::create_dir_all(folder).map_err(|reason| unwritable(folder, reason))?;
    let files = [("panda_mobile.srdf", SRDF), ("limits.yaml", LIMITS), ("panda_mobile.urdf", URDF)];
    for (name, text) in files {
        let path = folder.join(name);
        fs::write(&path, text).map_err(|reason| unwritable(&path, reason))?;
    }
    Ok(folder.join("panda_mobile.urdf"))
}

/// The robot with another tip or other values of the fingers.
pub(crate) fn panda_mobile_with(options: &RobotOptions) -> Result<Arc<Robot>, RobotError> {
    let text = |name: &str, text: &str| TextSource::Text { name: name.to_owned(), text: text.to_owned() };
    let mut options = options.clone();
    options.srdf.get_or_insert_with(|| text("panda_mobile.srdf", SRDF));
    options.limits.get_or_insert_with(|| text("limits.yaml", LIMITS));
    robot_file::with_open_hand(&options, |options| {
        Robot::from_urdf_text(URDF, "panda_mobile.urdf", None, options)
    })
    .map(Arc::new)
}

const URDF: &str = include_str!("../../../robots/panda_mobile/panda_mobile.urdf");
const SRDF: &str = include_str!("../../../robots/panda_mobile/panda_mobile.srdf");
const LIMITS: &str = include_str!("../../../robots/panda_mobile/limits.yaml");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_robot_is_whole() {
        let robot = panda_mobile().unwrap();
        assert_eq!(robot.dof(), 9);
        assert_eq!(robot.links()[robot.tip()].name, "panda_grasptarget");
        assert!(robot.limits().iter().all(|l| l.acceleration.is_some() && l.jerk.is_some()));
        let hand = hand::hand_links(&robot);
        let names: Vec<&str> = hand.iter().map(|&link| robot.links()[link].name.as_str()).collect();
        assert_eq!(names, ["panda_hand", "panda_leftfinger", "panda_rightfinger"]);
        // The pads stand 8 cm apart.
        let frames = robot.frames();
        let gap = frames.link(hand[1]).translation.vector - frames.link(hand[2]).translation.vector;
        assert!((gap.norm() - 0.08).abs() < 1e-9, "{gap}");
    }
}
