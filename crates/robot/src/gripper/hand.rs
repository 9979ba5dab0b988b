use std::collections::BTreeMap;

use cranny_spatial::Pose;

use crate::description::urdf_model::Urdf;
use crate::gripper::hand_description::{FingerRange, HandDescription};
use crate::gripper::hand_joint::HandJoint;
use crate::gripper::pad_distance::PadDistance;
use crate::tree::Tree;
use crate::{Link, Mover, RobotOptions};

/// The hand of a robot, as it is described.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotHand {
    /// What the robot's files do not say themselves.
    pub description: HandDescription,
    /// The joints that move while the hand closes, parents before children: those that the description names, and those
    /// that mimic them.
    pub joints: Vec<HandJoint>,
    /// How many fingers there are: of the joints right on the palm, all those on one side of the plane in which the pads
    /// meet move one finger, as the two knuckles of a parallel linkage do.
    pub fingers: usize,
    /// Distance of its pads as it closes, and the time that this takes.
    pub pads: PadDistance,
}

impl RobotHand {
    /// The first of the hands of `options` that the robot has: all its fingers. `links` stand where `rest` says, the hand
    /// open.
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
            // No joint has a velocity limit of zero: many files have it as a placeholder for an unknown one.
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

/// How far a joint of the file moves while the hand closes: as it is described, or as the one does that it mimics.
fn stroke(urdf: &Urdf, tree: &Tree, fingers: &BTreeMap<String, FingerRange>, joint: usize) -> f64 {
    let (mut joint, mut factor) = (joint, 1.0);
    // Mimicry has an end (`joint_group`).
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

/// Tells each joint its finger: on which side of the plane in which the pads meet the bodies are that it moves. How many
/// fingers there are.
fn sides(joints: &mut [HandJoint], links: &[Link], rest: &[Pose], tip: usize) -> usize {
    let tip_from_root = rest[tip].inverse();
    let root_of = |joints: &[HandJoint], mut joint: usize| {
        while let Some(above) = joints[joint].parent {
            joint = above;
        }
        joint
    };
    // Per joint right on the palm, how far the bodies beyond it reach to either side.
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
