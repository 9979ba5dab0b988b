use cranny_spatial::nalgebra::Translation3 as Translation;
use cranny_spatial::{Pose, Rotation};

use crate::hand::HandJoint;
use crate::link::JointKind;

/// How a hand holds something: what a mode of a task fixes between the joints of the arm (Hauser & Latombe 2010).
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

#[derive(Clone, Debug)]
pub(crate) struct LooseJoint {
    pub joint: HandJoint,
    /// While the hand is open, in the tip, or in the link of the joint above.
    pub parent_from_open: Pose,
}

impl LooseJoint {
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
