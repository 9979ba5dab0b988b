use std::collections::BTreeMap;

use cranny_spatial::Vector;
use serde::{Deserialize, Serialize};

use crate::limits::parse_yaml;
use crate::tree::Tree;
use crate::urdf::Urdf;
use crate::{JointGroup, JointKind, Link, Location, Mover, RobotError, RobotOptions};

/// What a URDF does not say of a parallel hand: `hand.yaml` in the folder of a robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandDescription {
    /// What it is called.
    pub name: String,
    /// The gripper frame: between the pads, y the axis on which they close, z the approach direction. Default as of
    /// [`RobotOptions::tip`].
    #[serde(default)]
    pub tip: Option<String>,
    /// Each finger by the name of its joint.
    pub fingers: BTreeMap<String, FingerRange>,
    /// Between the pads when the fingers stand open, in metres.
    pub opening_m: f64,
    /// How far behind the origin of the gripper frame the palm begins, in metres.
    pub finger_depth_m: f64,
    /// With what the pads press on what they hold, in newtons.
    pub closing_force_n: f64,
}

impl HandDescription {
    /// Reads the text of a `hand.yaml`; `file` is the name for it in errors.
    ///
    /// # Errors
    /// [`RobotError::Yaml`] or [`RobotError::Empty`] for a text that is none, [`RobotError::NotPositive`] for a figure
    /// that cannot be.
    pub fn parse(text: &str, file: &str) -> Result<Self, RobotError> {
        let hand: Self = parse_yaml(text, file)?;
        for (attribute, value) in [
            ("opening_m", hand.opening_m),
            ("finger_depth_m", hand.finger_depth_m),
            ("closing_force_n", hand.closing_force_n),
        ] {
            if !(value.is_finite() && value > 0.0) {
                let is_line = |line: &str| line.trim_start().starts_with(attribute);
                let line = text.lines().position(is_line).map_or(1, |line| line + 1);
                let line = u32::try_from(line).unwrap_or(u32::MAX);
                let (at, element) =
                    (Location { file: file.to_owned(), line }, format!("hand `{}`", hand.name));
                return Err(RobotError::NotPositive { at, element, attribute, value });
            }
        }
        Ok(hand)
    }
}

/// Where the joint of a finger stands (m, rad).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FingerRange {
    /// With the hand open.
    pub open: f64,
    /// With the hand closed on nothing.
    pub closed: f64,
}

/// The hand of a robot, as it is described.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotHand {
    /// What the robot's files do not say themselves.
    pub description: HandDescription,
    /// The fingers, in the order of their names.
    pub fingers: Vec<RobotFinger>,
}

/// A finger, which one joint moves on the palm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotFinger {
    /// The link right below the joint.
    pub link: usize,
    /// How the joint moves.
    pub kind: JointKind,
    /// Its axis in the frame of `link`, a unit vector.
    pub axis_in_link: Vector,
    /// Where it stands.
    pub range: FingerRange,
}

impl RobotHand {
    /// The first of the hands of `options` that the robot has: all its fingers.
    pub(crate) fn of(urdf: &Urdf, tree: &Tree, options: &RobotOptions) -> Option<Self> {
        let finger = |(name, range): (&String, &FingerRange)| {
            let joint = tree.joint(name)?;
            let motion = urdf.joints[joint].motion.as_ref()?;
            let (link, axis_in_link) = (tree.node_of_joint[joint], motion.axis_in_child);
            Some(RobotFinger { link, kind: motion.kind.into(), axis_in_link, range: *range })
        };
        options.hands.iter().find_map(|description| {
            let fingers: Option<Vec<RobotFinger>> = description.fingers.iter().map(finger).collect();
            Some(Self { description: description.clone(), fingers: fingers? })
        })
    }
}

impl RobotOptions {
    /// The same where the fingers of its hands stand open, and the gripper frame is theirs, as far as the robot has
    /// such joints and links and the options do not say otherwise.
    pub(crate) fn with_open_hands(&self, tree: &Tree) -> Self {
        let mut options = self.clone();
        for HandDescription { tip, fingers, .. } in &self.hands {
            options.tip = options.tip.or_else(|| tip.clone().filter(|tip| tree.node(tip).is_some()));
            // Who names it a joint of the group wants it to move.
            let is_in_group =
                |finger: &String| matches!(&self.group, JointGroup::Joints(names) if names.contains(finger));
            let is_held = |finger: &String| tree.joint(finger).is_some() && !is_in_group(finger);
            for (finger, range) in fingers.iter().filter(|(finger, _)| is_held(finger)) {
                options.fixed.entry(finger.clone()).or_insert(range.open);
            }
        }
        options
    }
}

/// The links of hand and fingers, by index: those with collision geometry that move as one with the tip,
/// without the link that the last joint moves, which belongs to the arm. A gripper mounted right on the last
/// joint, as one link with its flange, is that link itself.
pub(crate) fn hand_links(links: &[Link], movers: &[Vec<Mover>], tip: usize) -> Vec<usize> {
    let last_arm_link = movers[tip].last().map(|mover| mover.child_link);
    let moves_with_tip = |link: &usize| !links[*link].collisions.is_empty() && movers[*link] == movers[tip];
    let rigid: Vec<usize> = (0..links.len()).filter(moves_with_tip).collect();
    let hand: Vec<usize> = rigid.iter().copied().filter(|&link| Some(link) != last_arm_link).collect();
    if hand.is_empty() { rigid } else { hand }
}
