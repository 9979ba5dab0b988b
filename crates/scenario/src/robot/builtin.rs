use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_grasp::Hand;
use cranny_robot::{
    HandDescription, MountingJoint, Robot, RobotDescription, RobotError, RobotOptions, TextSource, UrdfText,
};
use cranny_spatial::Pose;
use cranny_task::robot_hand;

use crate::ScenarioError;
use crate::files::atomic_file::write_into;

/// Built-in robot; it needs no file.
#[derive(Clone, Copy, Debug)]
pub struct BuiltinRobot {
    /// Name in flags and scenario files; `-` is accepted for `_`.
    pub name: &'static str,
    /// Short description, in one line.
    pub about: &'static str,
    urdf: &'static str,
    /// Mounted components, each on top of the one before: the link on which it is mounted, and its URDF.
    carries: &'static [(&'static str, &'static str)],
    srdf: &'static str,
    limits: &'static [&'static str],
    description: &'static str,
    /// Hand, if the description does not contain it.
    hand: Option<&'static str>,
}

/// Text of a file of the built-in robots.
macro_rules! file {
    ($path:literal) => {
        include_str!(concat!("../../robots/", $path))
    };
}

const GRIPPER: &str = file!("gripper_85/gripper_85.urdf");
const GRIPPER_HAND: &str = file!("gripper_85/hand.yaml");
const UR5E: &str = file!("ur5e/ur5e.urdf");

/// All built-in robots; the first is that of the built-in scenarios.
pub const BUILTIN_ROBOTS: &[BuiltinRobot] = &[
    BuiltinRobot {
        name: "panda_mobile",
        about: "Franka Panda with its hand on a platform that drives along x and y, 9 joints",
        urdf: file!("panda_mobile/panda_mobile.urdf"),
        carries: &[],
        srdf: file!("panda_mobile/panda_mobile.srdf"),
        limits: &[file!("panda_mobile/limits.yaml")],
        description: file!("panda_mobile/robot.yaml"),
        hand: None,
    },
    BuiltinRobot {
        name: "ur5e",
        about: "UR5e with a gripper like a Robotiq 2F-85, fixed, 6 joints",
        urdf: UR5E,
        carries: &[("tool0", GRIPPER)],
        srdf: file!("ur5e/ur5e.srdf"),
        limits: &[file!("ur5e/limits.yaml")],
        description: file!("ur5e/robot.yaml"),
        hand: Some(GRIPPER_HAND),
    },
    BuiltinRobot {
        name: "ur5e_mobile",
        about: "the same on a platform that drives with a heading, 9 joints",
        urdf: file!("ur5e_mobile/platform.urdf"),
        carries: &[("platform_mount", UR5E), ("tool0", GRIPPER)],
        srdf: file!("ur5e/ur5e.srdf"),
        limits: &[file!("ur5e_mobile/platform_limits.yaml"), file!("ur5e/limits.yaml")],
        description: file!("ur5e_mobile/robot.yaml"),
        hand: Some(GRIPPER_HAND),
    },
    BuiltinRobot {
        name: "fr3",
        about: "Franka Research 3 with its hand, fixed, 7 joints",
        urdf: file!("fr3/fr3.urdf"),
        carries: &[],
        srdf: file!("fr3/fr3.srdf"),
        limits: &[file!("fr3/limits.yaml")],
        description: file!("fr3/robot.yaml"),
        hand: None,
    },
    BuiltinRobot {
        name: "fetch_like",
        about: "a mobile manipulator like the Fetch: base with a heading, torso that lifts, arm; 11 joints",
        urdf: file!("fetch_like/fetch_like.urdf"),
        carries: &[],
        srdf: file!("fetch_like/fetch_like.srdf"),
        limits: &[file!("fetch_like/limits.yaml")],
        description: file!("fetch_like/robot.yaml"),
        hand: None,
    },
];

/// Gripper to mount on an arm without one.
#[derive(Clone, Debug)]
pub struct MountedGripper {
    /// URDF, whose root is mounted on the flange.
    pub urdf: UrdfText,
    /// Description of the hand.
    pub hand: HandDescription,
    /// Pairs of its links that touch by design, although they are not adjacent.
    pub touching: Vec<[String; 2]>,
}

impl MountedGripper {
    /// Returns the gripper of the built-in `ur5e`.
    ///
    /// # Errors
    /// None unless the built-in files are broken.
    pub fn built_in() -> Result<Self, RobotError> {
        let linkage =
            |side: &str| [format!("gripper_{side}_inner_knuckle"), format!("gripper_{side}_finger")];
        let description = RobotDescription::parse(&hand_text(GRIPPER_HAND), "gripper_85/hand.yaml")?;
        let missing = || RobotError::Empty { file: "gripper_85/hand.yaml".to_owned() };
        Ok(Self {
            urdf: UrdfText::new(GRIPPER.to_owned(), "gripper_85.urdf")?,
            hand: description.hand.ok_or_else(missing)?,
            touching: ["left", "right"].map(linkage).to_vec(),
        })
    }
}

/// Returns the text of a hand as an element of a robot description.
fn hand_text(hand: &str) -> String {
    let indented = hand.lines().map(|line| format!("  {line}\n"));
    format!("hand:\n{}", indented.collect::<String>())
}

impl BuiltinRobot {
    /// Returns the built-in robot of that name.
    pub fn of_name(name: &str) -> Option<&'static Self> {
        BUILTIN_ROBOTS.iter().find(|robot| robot.name == name.replace('-', "_"))
    }

    /// Returns the names of all built-in robots, for a message about an unknown one.
    pub(crate) fn known() -> String {
        BUILTIN_ROBOTS.iter().map(|robot| robot.name).collect::<Vec<_>>().join(", ")
    }

    /// Returns the built-in robot that a flag names, unless a robot folder of that name exists.
    pub(crate) fn of_path(what: &Path) -> Option<&'static Self> {
        let is_folder = what.join("robot.yaml").is_file();
        what.to_str().and_then(Self::of_name).filter(|_| !is_folder)
    }

    /// Returns the robot, with another tip or other finger values if the options specify them.
    ///
    /// # Errors
    /// [`RobotError`] for options that do not fit it.
    pub fn robot(&self, options: &RobotOptions) -> Result<Arc<Robot>, RobotError> {
        let text = |name: String, text: &str| Some(TextSource::Text { name, text: text.to_owned() });
        let mut options = options.clone();
        options.srdf = options.srdf.or_else(|| {
            let (name, text) = self.srdf();
            Some(TextSource::Text { name, text })
        });
        options.limits = options.limits.or_else(|| text("limits.yaml".to_owned(), &self.limits()));
        options.description =
            options.description.or_else(|| text("robot.yaml".to_owned(), &self.description()));
        Robot::from_urdf_text(&self.urdf()?, &self.urdf_name(), None, &options).map(Arc::new)
    }

    /// Writes the robot's files into `folder`, for use by other programs, and returns the path of the URDF beside the others.
    ///
    /// # Errors
    /// [`ScenarioError::Unwritable`].
    pub fn write(&self, folder: &Path) -> Result<PathBuf, ScenarioError> {
        for (name, text) in [
            self.srdf(),
            ("limits.yaml".to_owned(), self.limits()),
            ("robot.yaml".to_owned(), self.description()),
            (self.urdf_name(), self.urdf()?),
        ] {
            write_into(folder, &name, text)?;
        }
        Ok(folder.join(self.urdf_name()))
    }

    /// Returns the name and the text of its SRDF.
    pub(crate) fn srdf(&self) -> (String, String) {
        (format!("{}.srdf", self.name), self.srdf.to_owned())
    }

    fn urdf_name(&self) -> String {
        format!("{}.urdf", self.name)
    }

    fn urdf(&self) -> Result<String, RobotError> {
        if self.carries.is_empty() {
            return Ok(self.urdf.to_owned());
        }
        let part = |text: &str| UrdfText::new(text.to_owned(), &self.urdf_name());
        let mut whole = part(self.urdf)?;
        for (mount, carried) in self.carries {
            let name = format!("{mount}_joint_to_what_it_carries");
            let joint = MountingJoint { name, kind: "fixed", mount_from_carried: Pose::identity() };
            whole = whole.carrying(mount, &part(carried)?, &joint)?;
        }
        Ok(whole.text().to_owned())
    }

    fn limits(&self) -> String {
        let joints = |text: &str| text.replace("joints:\n", "");
        let more = self.limits[1..].iter().map(|text| joints(text));
        self.limits[0].to_owned() + &more.collect::<String>()
    }

    fn description(&self) -> String {
        self.description.to_owned() + &self.hand.map_or_else(String::new, hand_text)
    }
}

/// Returns the robot of the built-in scenarios: a Panda with its hand, fingers open, on a holonomic base; nine joints.
///
/// # Errors
/// [`RobotError`] only if the built-in files are broken, which a test excludes.
pub fn panda_mobile() -> Result<Arc<Robot>, RobotError> {
    BUILTIN_ROBOTS[0].robot(&RobotOptions::default())
}

/// Returns its hand, with open fingers.
///
/// # Errors
/// As [`panda_mobile`].
pub fn panda_hand() -> Result<Hand, RobotError> {
    Ok(robot_hand(panda_mobile()?.as_ref()))
}

/// Returns the hands of the built-in robots, which are recognized by the names of their joints in any URDF.
pub(crate) fn known_hands() -> Result<Vec<HandDescription>, RobotError> {
    let mut hands = Vec::new();
    for robot in BUILTIN_ROBOTS {
        let description =
            RobotDescription::parse(&robot.description(), &format!("{}/robot.yaml", robot.name))?;
        hands.extend(description.hand);
    }
    Ok(hands)
}

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
        assert!(strokes.len() == 2 && (strokes[0] + strokes[1]).abs() < 1e-12, "{strokes:?}");
        // Both fingers meet in the middle, and neither moves along another axis.
        let to_middle = |finger: &Finger| 2.0 * finger.stroke_m.norm() - hand.opening_m;
        assert!(hand.fingers.iter().all(|finger| to_middle(finger).abs() < 1e-9), "{strokes:?}");
        assert!(hand.fingers.iter().all(|finger| finger.stroke_m.x.abs() + finger.stroke_m.z.abs() < 1e-9));
    }
}
