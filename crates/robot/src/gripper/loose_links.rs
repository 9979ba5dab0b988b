use cranny_spatial::nalgebra::Translation3 as Translation;
use cranny_spatial::{Pose, Rotation};

use crate::gripper::hand_joint::HandJoint;
use crate::link::JointKind;

/// Pose of an object in the closed hand and opening of the fingers, constant in one mode (Hauser & Latombe 2010, §3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Pose of the object in the tip frame.
    pub tip_from_held: Pose,
    /// Closing of the fingers, from 0, open, to 1.
    pub closing: f64,
}

/// Links posed relative to the tip by a [`Hold`]: the moving links of the hand, then the held object.
#[derive(Clone, Debug)]
pub(crate) struct LooseLinks {
    pub joints: Vec<LooseJoint>,
    /// Link of the held object.
    pub(crate) held: usize,
}

impl LooseLinks {
    pub(crate) fn len(&self) -> usize {
        self.joints.len() + 1
    }

    pub fn slot(&self, link: usize) -> Option<usize> {
        let joint = self.joints.iter().position(|joint| joint.joint.link == link);
        joint.or_else(|| (link == self.held).then(|| self.len() - 1))
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LooseJoint {
    pub joint: HandJoint,
    /// Pose with the hand open, in the tip frame or in the link of the joint above.
    pub parent_from_open: Pose,
}

impl LooseJoint {
    /// Returns the joints of a hand that is open in `rest`, the poses `root_from_link` of all links.
    pub fn all(joints: &[HandJoint], rest: &[Pose], tip: usize) -> Vec<Self> {
        let loose = |joint: &HandJoint| {
            let parent = joint.parent.map_or(tip, |parent| joints[parent].link);
            Self { joint: *joint, parent_from_open: rest[parent].inv_mul(&rest[joint.link]) }
        };
        joints.iter().map(loose).collect()
    }

    /// Returns the pose of the link below each joint in the tip frame.
    pub fn poses(joints: &[Self], closing: f64) -> Vec<Pose> {
        let mut poses: Vec<Pose> = Vec::with_capacity(joints.len() + 1);
        for joint in joints {
            let parent_from_link = joint.parent_from_link(closing);
            poses.push(match joint.joint.parent {
                Some(parent) => poses[parent] * parent_from_link,
                None => parent_from_link,
            });
        }
        poses
    }

    /// Returns the pose of the joint's child link in its parent link or the tip, with the fingers closed by `closing`.
    pub fn parent_from_link(&self, closing: f64) -> Pose {
        let by = self.joint.axis_in_link * (self.joint.stroke * closing);
        self.parent_from_open
            * match self.joint.kind {
                JointKind::Prismatic => Pose::from_parts(by.into(), Rotation::identity()),
                JointKind::Revolute => {
                    Pose::from_parts(Translation::identity(), Rotation::from_scaled_axis(by))
                }
            }
    }
}
