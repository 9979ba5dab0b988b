use cranny_spatial::nalgebra::Translation3 as Translation;
use cranny_spatial::{Pose, Rotation};

use crate::gripper::hand_joint::HandJoint;
use crate::link::JointKind;

/// The hold of a hand on something, which a mode of a task fixes between the joints of the arm (Hauser & Latombe 2010, §3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Where the thing is in the frame of the tip.
    pub tip_from_held: Pose,
    /// How far the fingers have closed, from 0, open, to 1.
    pub closing: f64,
}

/// Links that stand on the tip where a [`Hold`] puts them: those of the hand that move, then what they hold.
#[derive(Clone, Debug)]
pub(crate) struct LooseLinks {
    pub joints: Vec<LooseJoint>,
    /// The link of what is held.
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
    /// While the hand is open, in the tip, or in the link of the joint above.
    pub parent_from_open: Pose,
}

impl LooseJoint {
    /// The joints of a hand that stands open in `rest`, which has the `root_from_link` of every link, on links or the
    /// tip.
    pub fn all(joints: &[HandJoint], rest: &[Pose], tip: usize) -> Vec<Self> {
        let loose = |joint: &HandJoint| {
            let parent = joint.parent.map_or(tip, |parent| joints[parent].link);
            Self { joint: *joint, parent_from_open: rest[parent].inv_mul(&rest[joint.link]) }
        };
        joints.iter().map(loose).collect()
    }

    /// Pose of the link below each joint in the frame of the tip.
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

    /// Pose of the link below the joint in the link above it, or the tip, the fingers closed by the share `closing`.
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
