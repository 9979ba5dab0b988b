use cranny_spatial::{Point, Pose};

use crate::{GroupJoint, JointKind, Link, Mover, Robot};

impl Robot {
    /// Per joint of the group how far it moves the robot: for a revolute joint the farthest that any point
    /// beyond it lies from its origin at `q = 0`, in metres (so in m/rad); for a prismatic one 1 (m/m).
    pub fn joint_reaches(&self) -> &[f64] {
        &self.joint_reaches
    }
}

/// See [`Robot::joint_reaches`]; `rest` are the links in the root at `q = 0`, `movers` what moves each.
pub(crate) fn joint_reaches(
    joints: &[GroupJoint],
    links: &[Link],
    movers: &[Vec<Mover>],
    rest: &[Pose],
) -> Vec<f64> {
    let origin = |link: usize| rest[link].translation.vector;
    let reach = |joint: &GroupJoint| match joint.kind {
        JointKind::Prismatic => 1.0,
        JointKind::Revolute => (0..links.len())
            .filter(|&link| movers[link].iter().any(|mover| mover.child_link == joint.child_link))
            .flat_map(|link| links[link].collisions.iter().map(move |shape| (link, shape)))
            .map(|(link, shape)| {
                let ball = shape.solid.ball();
                let center: Point = rest[link] * (shape.link_from_shape * ball.center);
                (center.coords - origin(joint.child_link)).norm() + ball.radius_m
            })
            .fold(0.0, f64::max),
    };
    joints.iter().map(reach).collect()
}
