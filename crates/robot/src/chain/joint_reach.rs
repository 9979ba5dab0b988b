use cranny_spatial::{Point, Pose};

use crate::{GroupJoint, JointKind, Link, Mover, Robot};

impl Robot {
    /// Maximum motion of the robot per unit of each joint, one value per joint of the group: for a revolute joint the distance
    /// of the farthest point beyond it from its origin at `q = 0`, in metres (so in m/rad); for a prismatic joint 1 (m/m).
    pub fn joint_reaches(&self) -> &[f64] {
        &self.joint_reaches
    }
}

/// Computes [`Robot::joint_reaches`]; `rest` are the links in the root frame at `q = 0`, `movers` the movers of each.
pub(crate) fn joint_reaches(
    joints: &[GroupJoint],
    links: &[Link],
    movers: &[Vec<Mover>],
    rest: &[Pose],
) -> Vec<f64> {
    let slides = |joint: &GroupJoint| joint.kind == JointKind::Prismatic;
    let mut reaches: Vec<f64> = joints.iter().map(|joint| if slides(joint) { 1.0 } else { 0.0 }).collect();
    // The map from links to joints avoids a search of all links for each joint.
    let mut joint_of_child = vec![None; links.len()];
    for (index, joint) in joints.iter().enumerate().filter(|(_, joint)| !slides(joint)) {
        joint_of_child[joint.child_link] = Some(index);
    }
    for (link, shapes) in links.iter().enumerate().map(|(link, body)| (link, &body.collisions)) {
        for shape in shapes {
            let ball = shape.solid.ball();
            let center: Point = rest[link] * (shape.link_from_shape * ball.center);
            for mover in &movers[link] {
                let Some(joint) = joint_of_child[mover.child_link] else { continue };
                let origin = rest[mover.child_link].translation.vector;
                reaches[joint] = reaches[joint].max((center.coords - origin).norm() + ball.radius_m);
            }
        }
    }
    reaches
}
