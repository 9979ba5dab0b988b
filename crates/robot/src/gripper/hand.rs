use std::collections::BTreeMap;

use cranny_spatial::Pose;

use crate::description::urdf_model::Urdf;
use crate::gripper::hand_description::{FingerRange, HandDescription};
use crate::gripper::hand_joint::HandJoint;
use crate::gripper::pad_distance::PadDistance;
use crate::tree::Tree;
use crate::{Link, Mover, RobotOptions};

/// Hand of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotHand {
    /// Description of the hand beyond the robot's URDF.
    pub description: HandDescription,
    /// Joints that move while the hand closes, parents before children: those named in the description, and those that mimic
    /// them.
    pub joints: Vec<HandJoint>,
    /// Number of fingers: all joints attached to the palm on one side of the plane in which the pads meet move one finger,
    /// as the two knuckles of a parallel linkage do.
    pub fingers: usize,
    /// Distance between the pads while the hand closes, and the time that closing takes.
    pub pads: PadDistance,
}

impl RobotHand {
    /// Returns the gap that stays between the pads of the closed hand, in metres: no thinner object is held. It is 0 for a hand
    /// that does not close.
    pub fn closed_gap_m(&self) -> f64 {
        if self.fingers == 0 { 0.0 } else { self.pads.opening_m(1.0) }
    }

    /// Returns the first known hand of `options` whose fingers the robot has, if any; `rest`: poses of `links` with it open.
    pub(crate) fn of(
        urdf: &Urdf,
        tree: &Tree,
        options: &RobotOptions,
        (links, rest, tip): (&[Link], &[Pose], usize),
    ) -> Option<Self> {
        let has =
            |finger: &String| tree.joint(finger).is_some_and(|joint| urdf.joints[joint].motion.is_some());
        let known = options.known_hands.iter();
        let description = known.clone().find(|hand| hand.fingers.keys().all(has))?;
        let mut joints: Vec<HandJoint> = Vec::new();
        for (link, node) in tree.nodes.iter().enumerate() {
            let Some((_, joint)) = node.above else { continue };
            let Some(motion) = &urdf.joints[joint].motion else { continue };
            let stroke = stroke(urdf, tree, &description.fingers, joint);
            if stroke.abs() <= 0.0 {
                continue;
            }
            let mut above = std::iter::successors(node.above, |&(node, _)| tree.nodes[node].above);
            let parent = above.find_map(|(node, _)| joints.iter().position(|joint| joint.link == node));
            let (kind, axis_in_link) = (motion.kind.into(), motion.axis_in_child);
            // A velocity limit of 0 is a placeholder for an unknown one in many files; it is ignored.
            let velocity = motion.limits.velocity.filter(|velocity| *velocity > 0.0);
            let (finger, acceleration) = (0, motion.limits.acceleration);
            joints.push(HandJoint {
                link,
                parent,
                kind,
                axis_in_link,
                stroke,
                finger,
                velocity,
                acceleration,
            });
        }
        let fingers = sides(&mut joints, links, rest, tip);
        let pads = PadDistance::of(description, (&joints, fingers), (links, rest, tip));
        Some(Self { description: description.clone(), joints, fingers, pads })
    }
}

/// Returns the travel of a joint of the file from open to closed: as described, or as it follows from mimicry.
fn stroke(urdf: &Urdf, tree: &Tree, fingers: &BTreeMap<String, FingerRange>, joint: usize) -> f64 {
    let (mut joint, mut factor) = (joint, 1.0);
    // `joint_group` has checked that mimicry is not circular.
    loop {
        let described = &urdf.joints[joint];
        if let Some(range) = fingers.get(&described.name) {
            return factor * (range.closed - range.open);
        }
        let mimic = described.motion.as_ref().and_then(|motion| motion.mimic.as_ref());
        let Some((master, mimic)) = mimic.and_then(|mimic| Some((tree.joint(&mimic.master)?, mimic))) else {
            return 0.0;
        };
        (joint, factor) = (master, factor * mimic.multiplier);
    }
}

/// Assigns each joint to a finger: all joints on one side of the plane in which the pads meet move one finger. Returns the
/// number of fingers.
fn sides(joints: &mut [HandJoint], links: &[Link], rest: &[Pose], tip: usize) -> usize {
    let tip_from_root = rest[tip].inverse();
    let root_of = |joints: &[HandJoint], mut joint: usize| {
        while let Some(above) = joints[joint].parent {
            joint = above;
        }
        joint
    };
    // For each joint attached to the palm, the y farthest from 0 of the shapes that it moves, in the tip frame.
    let mut reach_m = vec![0.0_f64; joints.len()];
    for (index, link) in links.iter().enumerate() {
        let mut above = std::iter::successors(Some(index), |&link| links[link].parent);
        let moved_by = above.find_map(|link| joints.iter().position(|joint| joint.link == link));
        let Some(root) = moved_by.map(|joint| root_of(joints, joint)) else { continue };
        for shape in &link.collisions {
            let center_in_tip =
                tip_from_root * (rest[index] * (shape.link_from_shape * shape.solid.ball().center));
            if center_in_tip.y.abs() > reach_m[root].abs() {
                reach_m[root] = center_in_tip.y;
            }
        }
    }
    let first_side = reach_m.iter().find(|reach| reach.abs() > 0.0).map_or(1.0, |reach| reach.signum());
    for joint in 0..joints.len() {
        let is_opposite = reach_m[root_of(joints, joint)] * first_side < 0.0;
        joints[joint].finger = usize::from(is_opposite);
    }
    joints.iter().map(|joint| joint.finger + 1).max().unwrap_or(0)
}

/// Returns the indices of the links of hand and fingers: those with collision geometry that are rigid with the tip,
/// without the link that the last joint moves, which belongs to the arm. A gripper that is one link with its flange,
/// mounted directly on the last joint, is that link itself.
pub(crate) fn hand_links(links: &[Link], movers: &[Vec<Mover>], tip: usize) -> Vec<usize> {
    let last_arm_link = movers[tip].last().map(|mover| mover.child_link);
    let moves_with_tip = |link: &usize| !links[*link].collisions.is_empty() && movers[*link] == movers[tip];
    let rigid: Vec<usize> = (0..links.len()).filter(moves_with_tip).collect();
    let hand: Vec<usize> = rigid.iter().copied().filter(|&link| Some(link) != last_arm_link).collect();
    if hand.is_empty() { rigid } else { hand }
}
