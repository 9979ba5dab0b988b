use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_grasp::Hand;
use cranny_plan::robot_hand;
use cranny_robot::{Robot, RobotError, RobotOptions, TextSource};

use crate::{ScenarioError, robot_file};

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
    Ok(robot_hand(panda_mobile()?.as_ref()))
}

/// Writes the files of the built-in robot into `folder`, for programs of others, and returns the path of the
/// URDF; SRDF, limits and hand lie beside it.
///
/// # Errors
/// [`ScenarioError::Unwritable`].
pub fn write_panda_mobile(folder: &Path) -> Result<PathBuf, ScenarioError> {
    let unwritable = |path: &Path, reason| ScenarioError::Unwritable { path: path.to_owned(), reason };
    fs::create_dir_all(folder).map_err(|reason| unwritable(folder, reason))?;
    let files = [
        ("panda_mobile.srdf", SRDF),
        ("limits.yaml", LIMITS),
        ("hand.yaml", HAND),
        ("panda_mobile.urdf", URDF),
    ];
    for (name, text) in files {
        let path = folder.join(name);
        fs::write(&path, text).map_err(|reason| unwritable(&path, reason))?;
    }
    Ok(folder.join("panda_mobile.urdf"))
}

/// The robot with another tip or other values of the fingers.
pub(crate) fn panda_mobile_with(options: &RobotOptions) -> Result<Arc<Robot>, RobotError> {
    let text = |name: &str, text: &str| TextSource::Text { name: name.to_owned(), text: text.to_owned() };
    let mut options = robot_file::with_known_hands(options)?;
    options.srdf.get_or_insert_with(|| text("panda_mobile.srdf", SRDF));
    options.limits.get_or_insert_with(|| text("limits.yaml", LIMITS));
    Robot::from_urdf_text(URDF, "panda_mobile.urdf", None, &options).map(Arc::new)
}

const URDF: &str = include_str!("../../../robots/panda_mobile/panda_mobile.urdf");
const SRDF: &str = include_str!("../../../robots/panda_mobile/panda_mobile.srdf");
const LIMITS: &str = include_str!("../../../robots/panda_mobile/limits.yaml");
pub(crate) const HAND: &str = include_str!("../../../robots/panda_mobile/hand.yaml");

#[cfg(test)]
mod tests {
    use cranny_grasp::Finger;

    use super::*;

    #[test]
    fn the_built_in_robot_is_whole() {
        let robot = panda_mobile().unwrap();
        assert_eq!(robot.dof(), 9);
        assert_eq!(robot.links()[robot.tip()].name, "panda_grasptarget");
        assert!(robot.limits().iter().all(|l| l.acceleration.is_some() && l.jerk.is_some()));
        let hand = robot.hand_links();
        let names: Vec<&str> = hand.iter().map(|&link| robot.links()[link].name.as_str()).collect();
        assert_eq!(names, ["panda_hand", "panda_leftfinger", "panda_rightfinger"]);
        // The pads stand 8 cm apart.
        let frames = robot.frames();
        let gap = frames.link(hand[1]).translation.vector - frames.link(hand[2]).translation.vector;
        let hand = panda_hand().unwrap();
        assert!((gap.norm() - hand.opening_m).abs() < 1e-9, "{gap}");
        let strokes: Vec<f64> = hand.fingers.iter().map(|finger| finger.stroke_m.y).collect();
        assert_eq!((strokes.len(), strokes[0]), (2, -strokes[1]));
        // Both fingers meet in the middle, and neither moves along another axis.
        let to_middle = |finger: &Finger| 2.0 * finger.stroke_m.norm() - hand.opening_m;
        assert!(hand.fingers.iter().all(|finger| to_middle(finger).abs() < 1e-9), "{strokes:?}");
        assert!(hand.fingers.iter().all(|finger| finger.stroke_m.x.abs() + finger.stroke_m.z.abs() < 1e-9));
    }
}
