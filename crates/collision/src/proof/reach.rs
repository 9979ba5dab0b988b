use cranny_robot::JointKind;

use crate::cell::Cell;

/// Bound on the motion of any point of a robot, and of what it holds, against the world or against another link, when
/// its joints move by given amounts at any configuration: `Σ |δ_j| · reach_j`, mimic joints included.
///
/// The reach of a joint is the greatest distance of a point of any link beyond it from its axis: the distances between
/// the frames of the joints on the way there, sliding joints drawn out as far as they go, and the ball around the link
/// after the last of them. Only joints that move one of two links move them against each other, and each of these moves
/// one of them; so the bound holds for their distance too.
#[derive(Clone, Debug)]
pub struct Reach {
    /// Metres for a unit of each joint.
    per_joint_m: Vec<f64>,
}

impl Cell {
    /// The reach of each joint of the robot with what it holds.
    pub fn reach(&self) -> Reach {
        let robot = self.robot();
        let mut frames = self.scratch().frames;
        robot.forward_kinematics(&vec![0.0; robot.dof()], &mut frames);
        let origin = |link: usize| frames.link(link).translation.vector;
        // For each link that a joint ends in, the joint and its reach.
        let mut movers: Vec<Option<(usize, f64)>> = vec![None; robot.links().len() + 1];
        for body in self.bodies.iter() {
            let mut beyond = (frames.link(body.link) * body.bounds.ball.center).coords;
            let mut distance_m = body.bounds.ball.radius_m;
            for mover in robot.ancestors(body.link).iter().rev() {
                distance_m += (beyond - origin(mover.child_link)).norm();
                beyond = origin(mover.child_link);
                let scale = mover.multiplier.abs();
                let limits = &robot.limits()[mover.joint];
                let (reach_m, drawn_out_m) = match mover.kind {
                    JointKind::Revolute => (distance_m * scale, 0.0),
                    JointKind::Prismatic => (scale, scale * limits.lower.abs().max(limits.upper.abs())),
                };
                let known_m = movers[mover.child_link].map_or(0.0, |(_, reach_m)| reach_m);
                movers[mover.child_link] = Some((mover.joint, reach_m.max(known_m)));
                distance_m += drawn_out_m;
            }
        }
        let mut per_joint_m = vec![0.0; robot.dof()];
        for (joint, reach_m) in movers.into_iter().flatten() {
            per_joint_m[joint] += reach_m;
        }
        Reach { per_joint_m }
    }
}

impl Reach {
    /// The bound for the joints moving by `delta` (m, rad), in metres.
    pub fn motion_m(&self, delta: impl Fn(usize) -> f64) -> f64 {
        self.per_joint_m.iter().enumerate().map(|(joint, reach_m)| delta(joint).abs() * reach_m).sum()
    }

    pub(crate) fn weights(&self) -> &[f64] {
        &self.per_joint_m
    }
}
