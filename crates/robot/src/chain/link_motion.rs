use cranny_spatial::{Pose, Vector};

use crate::chain::joint_step::Motion;
use crate::{JointKind, LinkFrames, Robot};

/// Pose of a link relative to another link, as a function of the configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkMotion {
    /// Index of that other link, which precedes it; `None` for the root.
    pub parent: Option<usize>,
    /// Pose in the other link, at value 0 of the joint.
    pub parent_from_link: Pose,
    /// Joint between the two; `None` if they are rigidly connected.
    pub joint: Option<LinkJoint>,
}

/// Joint between two links, whose value is `multiplier · q[joint] + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkJoint {
    /// Kind of motion.
    pub kind: JointKind,
    /// Index in `q`.
    pub joint: usize,
    /// Factor on the value of that joint.
    pub multiplier: f64,
    /// Value at `q[joint] = 0`, in m or rad.
    pub offset: f64,
    /// Axis in the frame of the link, a unit vector.
    pub axis_in_link: Vector,
}

impl Robot {
    /// Returns the pose of every link as a function of `q`: what [`Self::forward_kinematics`] computes, up to rounding. The
    /// fingers and the held object have their poses in `frames`. A link that no joint moves is relative to the root.
    ///
    /// # Panics
    /// If `frames` belong to another robot.
    pub fn link_motions(&self, frames: &LinkFrames) -> Vec<LinkMotion> {
        let still = |link: usize| LinkMotion {
            parent: (link > 0).then_some(0),
            parent_from_link: self.rest[link],
            joint: None,
        };
        let mut motions: Vec<LinkMotion> = (0..self.links.len()).map(still).collect();
        for step in &self.steps {
            let axis = self.movers[step.link].iter().find(|mover| mover.child_link == step.link);
            let axis_in_link = axis.map_or_else(Vector::zeros, |mover| mover.axis_in_child);
            let (parent_from_link, joint) = match &step.motion {
                Motion::Rigid { parent_from_link } => (*parent_from_link, None),
                Motion::Loose { slot } => (frames.loose[*slot], None),
                Motion::Slide { value, rotation, translation, .. } => {
                    (Pose::from_parts((*translation).into(), *rotation), Some((JointKind::Prismatic, value)))
                }
                Motion::Turn { value, translation, at_zero, .. } => {
                    let rotation = cranny_spatial::Rotation::new_unchecked(*at_zero);
                    (Pose::from_parts((*translation).into(), rotation), Some((JointKind::Revolute, value)))
                }
            };
            let joint = joint.map(|(kind, value)| LinkJoint {
                kind,
                joint: value.joint,
                multiplier: value.multiplier,
                offset: value.offset,
                axis_in_link,
            });
            motions[step.link] = LinkMotion { parent: Some(step.parent), parent_from_link, joint };
        }
        motions
    }
}
