use cranny_spatial::nalgebra::Translation3 as Translation;
use cranny_spatial::{Pose, Rotation, Vector};

use crate::derived::Derived;
use crate::kinematics::{Motion, Step};
use crate::{JointKind, Link, LinkFrames, Robot};

/// How a hand holds something: what a mode of a task fixes between the joints of the arm (Hauser & Latombe 2010).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Where the thing is in the frame of the tip.
    pub tip_from_held: Pose,
    /// How far the fingers have closed, from 0, open, to 1.
    pub closing: f64,
}

/// Links that stand on the tip where a [`Hold`] puts them: the fingers, then what they hold.
#[derive(Clone, Debug)]
pub(crate) struct LooseLinks {
    /// Each finger, by its index in the hand's description.
    pub(crate) fingers: Vec<LooseFinger>,
    /// The link of what is held.
    pub(crate) held: usize,
}

#[derive(Clone, Debug)]
pub(crate) struct LooseFinger {
    pub(crate) link: usize,
    /// While the hand is open.
    tip_from_open: Pose,
    kind: JointKind,
    axis_in_link: Vector,
    /// From open to closed (m, rad).
    stroke: f64,
}

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
        let tip_from_root = self.rest[self.tip].inverse();
        let fingers: Vec<LooseFinger> = self
            .hand
            .iter()
            .flat_map(|hand| &hand.fingers)
            .map(|finger| LooseFinger {
                link: finger.link,
                tip_from_open: tip_from_root * self.rest[finger.link],
                kind: finger.kind,
                axis_in_link: finger.axis_in_link,
                stroke: finger.range.closed - finger.range.open,
            })
            .collect();
        let loose = LooseLinks { fingers, held };
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

    /// The links that stand where a [`Hold`] puts them: the fingers, then what they hold; none if nothing is held.
    pub fn loose_links(&self) -> impl Iterator<Item = usize> {
        let loose = self.loose.iter();
        loose.flat_map(|loose| loose.fingers.iter().map(|finger| finger.link).chain([loose.held]))
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

    /// The finger that a link is, or stands on, by its number in [`Self::hand`].
    pub fn finger_of(&self, link: usize) -> Option<usize> {
        let fingers = &self.hand.as_ref()?.fingers;
        let finger = |link: usize| fingers.iter().position(|finger| finger.link == link);
        std::iter::successors(Some(link), |&link| self.links[link].parent).find_map(finger)
    }

    /// Whether a link is a finger, or stands on one.
    pub fn is_of_finger(&self, link: usize) -> bool {
        self.finger_of(link).is_some()
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

    /// Where each of [`Self::loose_links`] stands in the frame of the tip.
    pub fn tip_from_loose(&self, hold: &Hold) -> impl Iterator<Item = Pose> {
        let (closing, tip_from_held) = (hold.closing, hold.tip_from_held);
        let fingers = self.loose.iter().flat_map(|loose| &loose.fingers);
        let closed = fingers.map(move |finger| {
            let by = finger.axis_in_link * (finger.stroke * closing);
            finger.tip_from_open
                * match finger.kind {
                    JointKind::Prismatic => Pose::from_parts(by.into(), Rotation::identity()),
                    JointKind::Revolute => {
                        Pose::from_parts(Translation::identity(), Rotation::from_scaled_axis(by))
                    }
                }
        });
        closed.chain(self.loose.iter().map(move |_| tip_from_held))
    }

    /// How each finger's joint moves, and by how much while the hand closes from open (m, rad).
    pub fn finger_strokes(&self) -> impl Iterator<Item = (JointKind, f64)> {
        let fingers = self.loose.iter().flat_map(|loose| &loose.fingers);
        fingers.map(|finger| (finger.kind, finger.stroke.abs()))
    }
}

impl LooseLinks {
    pub(crate) fn len(&self) -> usize {
        self.fingers.len() + 1
    }

    fn slot(&self, link: usize) -> Option<usize> {
        let finger = self.fingers.iter().position(|finger| finger.link == link);
        finger.or_else(|| (link == self.held).then(|| self.len() - 1))
    }
}
