use cranny_robot::{JointKind, LinkFrames};
use cranny_shape::Solid;
use cranny_spatial::{Point, Pose, Vector};

use crate::anatomy::Anatomy;

/// Hand at one configuration, in the frame of its palm link.
pub(crate) struct Posture<'a> {
    pub anatomy: &'a Anatomy,
    palm: usize,
    pub frames: LinkFrames,
}

impl<'a> Posture<'a> {
    /// Returns the hand of a palm link at `q` (m, rad; one per joint).
    pub fn at(anatomy: &'a Anatomy, palm: usize, q: &[f64]) -> Self {
        Self { anatomy, palm, frames: anatomy.robot.frames_at(q) }
    }

    pub fn origin(&self, link: usize) -> Point {
        (self.frames.link(self.palm).inverse() * self.frames.link(link)).translation.vector.into()
    }

    /// Returns the solids of a finger, each with its `palm_from_solid`.
    pub fn solids(&self, finger: usize) -> Vec<(Pose, Solid)> {
        self.anatomy.solids_in(&self.anatomy.branch(finger), self.palm, &self.frames)
    }

    /// Returns the solids of the palm, each with its `palm_from_solid`.
    pub fn palm_solids(&self) -> Vec<(Pose, Solid)> {
        self.anatomy.solids_in(&[self.anatomy.body_of[self.palm]], self.palm, &self.frames)
    }

    /// Returns the approximate tip of a finger: the centre of its solids or joint that is farthest from its hinge.
    pub fn tip(&self, finger: usize) -> Point {
        let hinge = self.origin(self.anatomy.bodies[finger].top);
        let ends = self.solids(finger).into_iter().map(|(pose, solid)| pose * solid.ball().center);
        let frames =
            self.anatomy.branch(finger).into_iter().map(|body| self.origin(self.anatomy.bodies[body].top));
        let ends: Vec<Point> = ends.chain(frames).collect();
        let farthest = ends.iter().max_by(|a, b| (*a - hinge).norm().total_cmp(&(*b - hinge).norm()));
        farthest.copied().unwrap_or(hinge)
    }

    /// Returns the axis of the joint directly above a finger, in the frame of the palm link.
    pub fn axis(&self, finger: usize) -> Option<(JointKind, Vector)> {
        let (_, mover) = self.anatomy.bodies[finger].above?;
        let palm_from_link = self.frames.link(self.palm).inverse() * self.frames.link(mover.child_link);
        Some((mover.kind, palm_from_link.rotation * mover.axis_in_child))
    }
}
