use cranny_spatial::{Point, Pose};

use crate::chain::derived::Derived;
use crate::chain::joint_step::{Motion, Step};
use crate::gripper::loose_links::{Hold, LooseJoint, LooseLinks};
use crate::{HandJoint, JointKind, Link, LinkFrames, Robot};

/// Maximum distance of a held object from the tip, in metres.
pub const FARTHEST_HELD_M: f64 = 2.0;

impl Robot {
    /// Returns this robot with a held object: one more link with this name, without geometry here, that moves with the tip.
    /// A [`Hold`] gives the poses of the object and of the fingers ([`Self::place_held`]). Initially the hand is open and the
    /// object is at the tip.
    ///
    /// If the robot already holds an object, the new one replaces it.
    #[must_use]
    pub fn holding(&self, name: &str) -> Self {
        let mut robot = self.clone();
        robot.derived = Derived::default();
        if let Some(loose) = &self.loose {
            name.clone_into(&mut robot.links[loose.held].name);
            return robot;
        }
        let held = robot.links.len();
        robot.links.push(Link {
            name: name.to_owned(),
            parent: Some(self.tip),
            collisions: Vec::new(),
            visuals: Vec::new(),
            inertial: None,
        });
        robot.movers.push(self.movers[self.tip].clone());
        robot.rest.push(self.rest[self.tip]);
        let hand_joints = self.hand.as_ref().map_or(&[][..], |hand| &hand.joints);
        let loose = LooseLinks { joints: LooseJoint::all(hand_joints, &self.rest, self.tip), held };
        // Links attached to a finger follow it; both come after the tip.
        let is_loose = |link: usize| {
            std::iter::successors(Some(link), |&link| self.links[link].parent)
                .find_map(|link| loose.slot(link))
        };
        let (mut steps, later): (Vec<Step>, Vec<Step>) =
            self.steps.iter().cloned().partition(|step| is_loose(step.link).is_none());
        for mut step in later {
            if let Some(slot) = loose.slot(step.link) {
                (step.parent, step.motion) = (self.tip, Motion::Loose { slot });
            }
            steps.push(step);
        }
        steps.push(Step { link: held, parent: self.tip, motion: Motion::Loose { slot: loose.len() - 1 } });
        robot.steps = steps;
        robot.loose = Some(loose);
        robot
    }

    /// Link of the held object, if the robot holds one.
    pub fn held_link(&self) -> Option<usize> {
        self.loose.as_ref().map(|loose| loose.held)
    }

    /// Links posed by a [`Hold`]: those directly below a joint of the hand, then the held object; none if nothing is held.
    pub fn loose_links(&self) -> impl Iterator<Item = usize> {
        let loose = self.loose.iter();
        loose.flat_map(|loose| loose.joints.iter().map(|joint| joint.joint.link).chain([loose.held]))
    }

    /// Returns the loose link that a link is attached to, as an index into [`Self::loose_links`].
    pub(crate) fn loose_slot_of(&self, link: usize) -> Option<usize> {
        let loose = self.loose.as_ref()?;
        std::iter::successors(Some(link), |&link| self.links[link].parent).find_map(|link| loose.slot(link))
    }

    /// Returns true if a link is posed by a [`Hold`], or attached to one that is.
    pub fn is_loose(&self, link: usize) -> bool {
        self.loose_slot_of(link).is_some()
    }

    /// Returns the last joint of the hand above a link, as an index into the joints of [`Self::hand`].
    fn hand_joint_of(&self, link: usize) -> Option<usize> {
        let joints = &self.hand.as_ref()?.joints;
        let joint = |link: usize| joints.iter().position(|joint| joint.link == link);
        std::iter::successors(Some(link), |&link| self.links[link].parent).find_map(joint)
    }

    /// Returns the finger that a link belongs to, counted from 0.
    pub fn finger_of(&self, link: usize) -> Option<usize> {
        let joint = self.hand_joint_of(link)?;
        self.hand.as_ref().map(|hand| hand.joints[joint].finger)
    }

    /// Returns true if a link belongs to a finger.
    pub fn is_of_finger(&self, link: usize) -> bool {
        self.finger_of(link).is_some()
    }

    /// Returns true if a link bears a pad, or is rigidly connected with one that does; false for the other links of a finger,
    /// such as knuckles.
    pub fn bears_pad(&self, link: usize) -> bool {
        let joint = self.hand_joint_of(link);
        joint.zip(self.hand.as_ref()).is_some_and(|(joint, hand)| hand.pads.is_below(joint))
    }

    /// Bounds the motion of any point of a ball on a link, in metres, while the hand closes from open; `ball` is its centre in
    /// the link frame and its radius, in metres. 0 for a link that does not belong to a finger.
    ///
    /// Each joint above moves the point by its stroke, multiplied for a revolute joint by an upper bound on the distance of the
    /// point from its axis: the length of the chain between.
    pub fn closing_motion_bound_m(&self, link: usize, (center, radius_m): (Point, f64)) -> f64 {
        let Some(hand) = &self.hand else { return 0.0 };
        let mut below = self.hand_joint_of(link);
        let in_joint = |joint: &HandJoint| self.rest[joint.link].inv_mul(&self.rest[link]) * center;
        let mut lever_m = below.map_or(0.0, |joint| in_joint(&hand.joints[joint]).coords.norm()) + radius_m;
        let mut way_m = 0.0;
        while let Some(joint) = below.map(|below| &hand.joints[below]) {
            way_m += joint.stroke.abs()
                * match joint.kind {
                    JointKind::Revolute => lever_m,
                    JointKind::Prismatic => 1.0,
                };
            if let Some(parent) = joint.parent {
                let parent_from_link = self.rest[hand.joints[parent].link].inv_mul(&self.rest[joint.link]);
                lever_m += parent_from_link.translation.vector.norm();
            }
            if joint.kind == JointKind::Prismatic {
                lever_m += joint.stroke.abs();
            }
            below = joint.parent;
        }
        way_m
    }

    /// Sets the hold in `frames`; the poses of the loose links are valid after the next call of
    /// [`Self::forward_kinematics`]. Has no effect for a robot that holds nothing.
    ///
    /// # Panics
    /// If the frames belong to another robot.
    pub fn place_held(&self, hold: &Hold, frames: &mut LinkFrames) {
        let Some(loose) = &self.loose else { return };
        assert_eq!(frames.loose.len(), loose.len(), "frames of this robot");
        for (place, pose) in frames.loose.iter_mut().zip(self.tip_from_loose(hold)) {
            *place = pose;
        }
    }

    /// Sets the hold as [`Self::place_held`], with each finger closed by its own share of its travel (`closings`, one per
    /// finger, from 0 to 1); a finger without a share stays open.
    ///
    /// # Panics
    /// If the frames belong to another robot.
    pub fn place_fingers(&self, tip_from_held: Pose, closings: &[f64], frames: &mut LinkFrames) {
        let links: Vec<usize> = self.loose_links().collect();
        self.place_held(&Hold { tip_from_held, closing: 0.0 }, frames);
        for (finger, &closing) in closings.iter().enumerate() {
            let poses = self.tip_from_loose(&Hold { tip_from_held, closing });
            for ((place, pose), link) in frames.loose.iter_mut().zip(poses).zip(&links) {
                if self.finger_of(*link) == Some(finger) {
                    *place = pose;
                }
            }
        }
    }

    /// Returns the poses of [`Self::loose_links`] in the tip frame.
    pub fn tip_from_loose(&self, hold: &Hold) -> Vec<Pose> {
        let Some(loose) = &self.loose else { return Vec::new() };
        let mut poses = LooseJoint::poses(&loose.joints, hold.closing);
        poses.push(hold.tip_from_held);
        poses
    }
}
