use cranny_robot::JointKind;

use crate::cell::Cell;

/// Bound on the motion of any point of a robot, and of its held object, against the world or against another link, for given
/// motions of the joints in any configuration: `Σ |δ_j| · reach_j`, mimic joints included.
///
/// The reach of a joint is the greatest distance from its axis of a point of any link beyond it: the sum of the distances
/// between the frames of the joints up to the link, prismatic joints fully extended, and the ball around the link after the
/// last of them. A joint moves two links against each other only if it moves exactly one of them, so the bound is also valid
/// for their distance.
#[derive(Clone, Debug)]
pub struct Reach {
    /// Reach of each joint, in metres per unit of the joint.
    per_joint_m: Vec<f64>,
}

impl Cell {
    /// Computes the reach of each joint of the robot with its held object.
    pub fn reach(&self) -> Reach {
        let robot = self.robot();
        let mut frames = self.scratch().frames;
        robot.forward_kinematics(&vec![0.0; robot.dof()], &mut frames);
        // Joint and reach, by child link of a joint.
        let mut movers: Vec<Option<(usize, f64)>> = vec![None; robot.links().len() + 1];
        for body in self.bodies.iter() {
            let ball = &body.bounds.ball;
            let arms_m = robot.link_arms_m(&frames, body.link, &ball.center);
            for (mover, arm_m) in robot.ancestors(body.link).iter().zip(arms_m) {
                let reach_m = mover.multiplier.abs()
                    * match mover.kind {
                        JointKind::Revolute => arm_m + ball.radius_m,
                        JointKind::Prismatic => arm_m,
                    };
                let known_m = movers[mover.child_link].map_or(0.0, |(_, reach_m)| reach_m);
                movers[mover.child_link] = Some((mover.joint, reach_m.max(known_m)));
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
    /// Returns the bound for a joint motion `delta` (m, rad), in metres.
    pub fn motion_m(&self, delta: impl Fn(usize) -> f64) -> f64 {
        self.per_joint_m.iter().enumerate().map(|(joint, reach_m)| delta(joint).abs() * reach_m).sum()
    }

    pub(crate) fn weights(&self) -> &[f64] {
        &self.per_joint_m
    }
}
