use cranny_spatial::{Point, Pose};

use crate::chain::derived::Derived;
use crate::chain::joint_step::{Motion, Step};
use crate::gripper::loose_links::{Hold, LooseJoint, LooseLinks};
use crate::{HandJoint, JointKind, Link, LinkFrames, Robot};

/// What is held stands no farther from the tip than this, in metres.
pub const FARTHEST_HELD_M: f64 = 2.0;

impl Robot {
    /// The same robot with something in its hand: one more link, which is named as told, has no geometry here, and moves
    /// with the tip. Where it and the fingers stand is said by a [`Hold`] ([`Self::place_held`]); until then the hand is
    /// open, and the thing at the tip.
    ///
    /// A robot that holds something already is asked again for something else.
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
        // What hangs on a finger follows it; both come after the tip.
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

    /// The link of what is held, of a robot that holds something.
    pub fn held_link(&self) -> Option<usize> {
        self.loose.as_ref().map(|loose| loose.held)
    }

    /// The links that stand where a [`Hold`] puts them: those right below a joint of the hand, then what it holds; none if
    /// nothing is held.
    pub fn loose_links(&self) -> impl Iterator<Item = usize> {
        let loose = self.loose.iter();
        loose.flat_map(|loose| loose.joints.iter().map(|joint| joint.joint.link).chain([loose.held]))
    }

    /// The loose link that a link stands on, by its place among [`Self::loose_links`].
    pub(crate) fn loose_slot_of(&self, link: usize) -> Option<usize> {
        let loose = self.loose.as_ref()?;
        std::iter::successors(Some(link), |&link| self.links[link].parent).find_map(|link| loose.slot(link))
    }

    /// Whether a link stands where a [`Hold`] puts it, or on one that does.
    pub fn is_loose(&self, link: usize) -> bool {
        self.loose_slot_of(link).is_some()
    }

    /// The joint of the hand that moves a link last, by its number in [`Self::hand`].
    fn hand_joint_of(&self, link: usize) -> Option<usize> {
        let joints = &self.hand.as_ref()?.joints;
        let joint = |link: usize| joints.iter().position(|joint| joint.link == link);
        std::iter::successors(Some(link), |&link| self.links[link].parent).find_map(joint)
    }

    /// The finger that a link is part of, counted from 0.
    pub fn finger_of(&self, link: usize) -> Option<usize> {
        let joint = self.hand_joint_of(link)?;
        self.hand.as_ref().map(|hand| hand.joints[joint].finger)
    }

    /// Whether a link is part of a finger.
    pub fn is_of_finger(&self, link: usize) -> bool {
        self.finger_of(link).is_some()
    }

    /// A bound on how far any point of a ball on a link moves, in metres, while the hand closes from open; `ball` is its
    /// center in the link and its radius. 0 for a link that is no part of a finger.
    ///
    /// Each joint above moves the point by its stroke, and if it turns, by that times how far the point can be from its
    /// axis: the way through the joints between.
    pub fn closing_way_m(&self, link: usize, (center, radius_m): (Point, f64)) -> f64 {
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

    /// Tells the frames how the hand holds what it holds; those of the loose links are right after the next call of
    /// [`Self::forward_kinematics`]. Of a robot that holds nothing nothing changes.
    ///
    /// # Panics
    /// If the frames come from another robot.
    pub fn place_held(&self, hold: &Hold, frames: &mut LinkFrames) {
        let Some(loose) = &self.loose else { return };
        assert_eq!(frames.loose.len(), loose.len(), "frames of this robot");
        for (place, pose) in frames.loose.iter_mut().zip(self.tip_from_loose(hold)) {
            *place = pose;
        }
    }

    /// As [`Self::place_held`], with every finger closed by its own share of its travel (`closings`, one per finger,
    /// from 0 to 1); a finger without a share stays open.
    ///
    /// # Panics
    /// If the frames come from another robot.
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

    /// Where each of [`Self::loose_links`] stands in the frame of the tip.
    pub fn tip_from_loose(&self, hold: &Hold) -> Vec<Pose> {
        let Some(loose) = &self.loose else { return Vec::new() };
        let mut poses = LooseJoint::poses(&loose.joints, hold.closing);
        poses.push(hold.tip_from_held);
        poses
    }
}
