use std::collections::BTreeMap;

use cranny_spatial::Vector;
use serde::{Deserialize, Serialize};

use crate::assembly::parsed;
use crate::joint_group::{named_group, range, unknown_joint, unknown_link};
use crate::limits::parse_yaml;
use crate::tree::Tree;
use crate::urdf::Urdf;
use crate::{JointKind, Link, Location, Mover, RobotError, RobotOptions, Srdf};

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
    /// [`RobotError::Yaml`] or [`RobotError::Empty`] for a text that is none, [`RobotError::HandFigure`] for a figure
    /// that cannot be.
    pub fn parse(text: &str, file: &str) -> Result<Self, RobotError> {
        let hand: Self = parse_yaml(text, file)?;
        let of_hand = || format!("hand `{}`", hand.name);
        for (attribute, value) in [
            ("opening_m", hand.opening_m),
            ("finger_depth_m", hand.finger_depth_m),
            ("closing_force_n", hand.closing_force_n),
        ] {
            if !(value.is_finite() && value > 0.0) {
                let (at, range) = (line_of(text, file, attribute), "a number greater than 0".to_owned());
                return Err(RobotError::HandFigure { at, element: of_hand(), attribute, value, range });
            }
        }
        if hand.fingers.is_empty() {
            let (at, range) = (line_of(text, file, "fingers"), "at least 1".to_owned());
            let (element, attribute) = (of_hand(), "the number of fingers");
            return Err(RobotError::HandFigure { at, element, attribute, value: 0.0, range });
        }
        hand.check_fingers(text, file, |_| (f64::MIN, f64::MAX))?;
        Ok(hand)
    }

    /// Whether the joint of each finger can stand where it is to stand, open and closed; `limits` by its name.
    fn check_fingers(
        &self,
        text: &str,
        file: &str,
        limits: impl Fn(&str) -> (f64, f64),
    ) -> Result<(), RobotError> {
        for (finger, places) in &self.fingers {
            for (attribute, value) in [("open", places.open), ("closed", places.closed)] {
                let (lower, upper) = limits(finger);
                if !(lower..=upper).contains(&value) {
                    let (at, element) = (line_of(text, file, finger), format!("finger `{finger}`"));
                    let range = match lower {
                        f64::MIN => "a number".to_owned(),
                        _ => format!("between {lower} and {upper}, the limits of the joint"),
                    };
                    return Err(RobotError::HandFigure { at, element, attribute, value, range });
                }
            }
        }
        Ok(())
    }
}

/// The line of a text that begins with a key.
fn line_of(text: &str, file: &str, key: &str) -> Location {
    let line = text.lines().position(|line| line.trim_start().starts_with(key));
    let line = u32::try_from(line.map_or(1, |line| line + 1)).unwrap_or(u32::MAX);
    Location { file: file.to_owned(), line }
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
        options.known_hands.iter().find_map(|description| {
            let fingers: Option<Vec<RobotFinger>> = description.fingers.iter().map(finger).collect();
            Some(Self { description: description.clone(), fingers: fingers? })
        })
    }
}

impl RobotOptions {
    /// The same with the robot's own hand as the first of those that are known, fingers open, and the gripper frame as
    /// the tip, as far as the robot has such joints and links and the options do not say otherwise.
    pub(crate) fn with_open_hands(
        &self,
        urdf: &Urdf,
        tree: &Tree,
        srdf: Option<&Srdf>,
    ) -> Result<Self, RobotError> {
        let mut options = self.clone();
        let motion = |finger: &str| urdf.joints[tree.joint(finger)?].motion.as_ref();
        let limits = |finger: &str| motion(finger).map_or((f64::MIN, f64::MAX), range);
        let own = parsed(self.hand.as_ref(), |text, file| {
            let own = HandDescription::parse(text, file)?;
            own.check_fingers(text, file, limits)?;
            Ok(own)
        })?;
        if let Some(own) = own {
            let place = || format!("{}: hand `{}`", urdf.file, own.name);
            if let Some(finger) = own.fingers.keys().find(|finger| tree.joint(finger).is_none()) {
                return Err(unknown_joint(urdf, place(), finger));
            }
            if let Some(tip) = own.tip.as_ref().filter(|tip| tree.node(tip).is_none()) {
                return Err(unknown_link(urdf, place(), tip));
            }
            options.known_hands.insert(0, own);
        }
        // Who names a finger's joint one of the group wants it to move; one that mimics another follows it.
        let group = named_group(urdf, tree, srdf, self)?;
        let is_held = |finger: &String| {
            let mimics = motion(finger).is_some_and(|motion| motion.mimic.is_some());
            tree.joint(finger).is_some_and(|joint| !group.contains(&joint)) && !mimics
        };
        for HandDescription { tip, fingers, .. } in &options.known_hands {
            options.tip = options.tip.or_else(|| tip.clone().filter(|tip| tree.node(tip).is_some()));
            for (finger, range) in fingers.iter().filter(|(finger, _)| is_held(finger)) {
                options.fixed.entry(finger.clone()).or_insert(range.open);
            }
        }
        Ok(options)
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
