use cranny_robot::{JointKind, LinkFrames, Robot};
use cranny_spatial::{Point, Pose, Vector};

use crate::joint_curve::{JointCurve, Middle};
use crate::model::Model;
use crate::span::{Object, Span};

/// Robot in the middle of a curve.
pub(crate) struct Moment {
    middle: Middle,
    pub frames: LinkFrames,
}

/// Part of an object in the middle of a curve, in a common frame: its pose, the velocity of the point `center`, the angular
/// velocity, and bounds on the acceleration of its points and of its directions of length 1 along the curve.
pub(crate) struct Moved {
    pub pose: Pose,
    pub center: Vector,
    pub radius_m: f64,
    pub velocity: Vector,
    pub turn: Vector,
    pub acceleration: f64,
    pub swing: f64,
}

impl Moment {
    /// Computes the frames from those of the cell, which hold the poses of fingers and held object.
    pub fn of(robot: &Robot, mut frames: LinkFrames, curve: &JointCurve) -> Self {
        let middle = Middle::of(curve);
        robot.forward_kinematics(&middle.q, &mut frames);
        Self { middle, frames }
    }

    /// Computes the motion relative to the link `top`, or to the world, of a part of an object that is in a ball, given by its
    /// centre and radius.
    pub fn moved(
        &self,
        model: &Model,
        top: Option<usize>,
        of: usize,
        (center, radius_m): (Vector, f64),
    ) -> Moved {
        let object = &model.objects[of];
        let top_from_world = top.map_or_else(Pose::identity, |top| self.frames.link(top).inverse());
        let in_top = |link: usize| top_from_world * self.frames.link(link);
        let pose = if object.motion.is_some() { in_top(of) } else { top_from_world };
        let center = (pose * Point::from(center)).coords;
        let mut moved = Moved {
            pose,
            center,
            radius_m,
            velocity: Vector::zeros(),
            turn: Vector::zeros(),
            acceleration: 0.0,
            swing: 0.0,
        };
        let chain = model.chain(top, of);
        let joints: Vec<_> = chain
            .iter()
            .filter_map(|link| Some((*link, model.objects[*link].motion.as_ref()?.joint?)))
            .collect();
        let fastest = |joint: usize, multiplier: f64| self.middle.fastest[joint] * multiplier.abs();
        let mut before: f64 = joints
            .iter()
            .filter(|(_, j)| j.kind == JointKind::Revolute)
            .map(|(_, j)| fastest(j.joint, j.multiplier))
            .sum();
        let mut beyond = 0.0;
        for (link, joint) in joints.iter().rev() {
            let fastest = fastest(joint.joint, joint.multiplier);
            let rate = self.middle.rate[joint.joint] * joint.multiplier;
            let bend = self.middle.most_bend[joint.joint] * joint.multiplier.abs();
            let frame = in_top(*link);
            let axis = frame.rotation * joint.axis_in_link;
            match joint.kind {
                JointKind::Revolute => {
                    before -= fastest;
                    let arm = axis.cross(&(center - frame.translation.vector));
                    let reach = arm.norm() + radius_m + 0.5 * beyond;
                    moved.velocity += arm * rate;
                    moved.turn += axis * rate;
                    let turning = fastest * (fastest + 2.0 * before) + bend;
                    moved.acceleration += reach * turning;
                    moved.swing += turning;
                    beyond += fastest * reach;
                }
                JointKind::Prismatic => {
                    moved.velocity += axis * rate;
                    moved.acceleration += 2.0 * fastest * before + bend;
                    beyond += fastest;
                }
            }
        }
        moved
    }
}

impl Moved {
    /// Returns the point of the span that is farthest along `n` at the parameter `s` beside the middle, to first order.
    pub fn farthest(&self, object: &Object, span: Span, n: &Vector, s: f64) -> Vector {
        let along = n + n.cross(&self.turn) * s;
        let local = object.support(span, &self.pose.rotation.inverse_transform_vector(&along)).1;
        let point = (self.pose * Point::from(local)).coords;
        point + (self.velocity + self.turn.cross(&(point - self.center))) * s
    }

    /// Returns a bound on the motion of its points within the curve, from the middle, in metres.
    pub fn most_m(&self) -> f64 {
        0.5 * (self.velocity.norm() + self.turn.norm() * self.radius_m) + 0.125 * self.acceleration
    }
}
