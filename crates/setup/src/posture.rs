use cranny_robot::{JointKind, LinkFrames};
use cranny_shape::{Solid, separation};
use cranny_spatial::{Point, Pose, Vector};

use crate::anatomy::Anatomy;
use crate::hand_guess::HandGuess;

/// A hand at one configuration, in the frame of its palm link.
pub(crate) struct Posture<'a> {
    pub anatomy: &'a Anatomy,
    palm: usize,
    frames: LinkFrames,
}

impl<'a> Posture<'a> {
    pub fn at(anatomy: &'a Anatomy, palm: usize, q: &[f64]) -> Self {
        Self { anatomy, palm, frames: anatomy.robot.frames_at(q) }
    }

    pub fn origin(&self, link: usize) -> Point {
        (self.frames.link(self.palm).inverse() * self.frames.link(link)).translation.vector.into()
    }

    pub fn solids(&self, finger: usize) -> Vec<(Pose, Solid)> {
        self.anatomy.solids_in(&self.anatomy.branch(finger), self.palm, &self.frames)
    }

    /// The bodies of the palm itself.
    pub fn palm_solids(&self) -> Vec<(Pose, Solid)> {
        self.anatomy.solids_in(&[self.anatomy.body_of[self.palm]], self.palm, &self.frames)
    }

    /// About where a finger ends: the middle of that part that is farthest from where it is hinged.
    pub fn tip(&self, finger: usize) -> Point {
        let hinge = self.origin(self.anatomy.bodies[finger].top);
        let ends = self.solids(finger).into_iter().map(|(pose, solid)| pose * solid.ball().center);
        let frames =
            self.anatomy.branch(finger).into_iter().map(|body| self.origin(self.anatomy.bodies[body].top));
        let ends: Vec<Point> = ends.chain(frames).collect();
        let farthest = ends.iter().max_by(|a, b| (*a - hinge).norm().total_cmp(&(*b - hinge).norm()));
        farthest.copied().unwrap_or(hinge)
    }

    /// The axis of the joint right above a finger.
    pub fn axis(&self, finger: usize) -> Option<(JointKind, Vector)> {
        let (_, mover) = self.anatomy.bodies[finger].above?;
        let palm_from_link = self.frames.link(self.palm).inverse() * self.frames.link(mover.child_link);
        Some((mover.kind, palm_from_link.rotation * mover.axis_in_child))
    }
}

/// Links whose bodies are marks: specks that float between the pads and touch nothing, as some put them where the hand
/// grasps. With them every grasp would collide.
pub(crate) fn marks(anatomy: &Anatomy, guess: &HandGuess) -> Vec<usize> {
    /// A mark is no larger, in metres, and this far from everything else.
    const LARGEST_M: f64 = 0.02;
    const APART_M: f64 = 3e-3;
    let mut q = anatomy.rest();
    for (joint, value) in q.iter_mut().enumerate() {
        *value = guess.fingers.get(&anatomy.robot.joint_names()[joint]).map_or(*value, |range| range.open);
    }
    let posture = Posture::at(anatomy, guess.palm, &q);
    let body = anatomy.body_of[guess.palm];
    let placed = |link: usize| -> Vec<(Pose, Solid)> {
        let palm_from_link = posture.frames.link(guess.palm).inverse() * posture.frames.link(link);
        let shapes = anatomy.robot.links()[link].collisions.iter();
        shapes.map(|shape| (palm_from_link * shape.link_from_shape, shape.solid.clone())).collect()
    };
    let origin = guess.palm_from_frame.translation.vector;
    let is_mark = |&link: &usize| {
        let own = placed(link);
        let is_small = own.iter().all(|(pose, solid)| {
            let ball = solid.ball();
            let from_frame_m = ((pose * ball.center).coords - origin).norm();
            ball.radius_m < LARGEST_M && from_frame_m < 0.5 * guess.opening_m + ball.radius_m
        });
        let branch = anatomy.branch(body).into_iter().flat_map(|body| &anatomy.bodies[body].links);
        let mut others = branch.filter(|other| **other != link).flat_map(|&other| placed(other));
        let is_apart = others.all(|(pose_b, b)| {
            own.iter().all(|(pose_a, a)| separation(a, pose_a, &b, &pose_b, APART_M).lower_m >= APART_M)
        });
        !own.is_empty() && is_small && is_apart
    };
    anatomy.bodies[body].links.iter().copied().filter(is_mark).collect()
}
