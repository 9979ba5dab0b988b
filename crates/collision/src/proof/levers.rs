use cranny_robot::JointKind;

use crate::cell::{Cell, Scratch};
use crate::pair::pairs::Other;
use crate::proof::joint_curve::JointCurve;

/// Levers by which errors of the joints, and of the robot's placement, move the collision geometry along a path.
///
/// If every revolute joint is off by at most θ, a point of a link moves by at most θ times the sum of its levers. The lever of
/// a joint is the length from its origin to the point through the origins of the joints beyond, which bounds the distance from
/// the axis in any configuration. Prismatic joints change that length: along a straight edge it is a convex function of the
/// position on the edge, so its maximum is at a way point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Levers {
    /// Lever of all revolute joints together, against the world, and between two links, in metres per radian.
    pub turning_m: [f64; 2],
    /// Lever of all prismatic joints together, in metres per metre.
    pub sliding: [f64; 2],
    /// Maximum distance of any point from the origin of the root, in metres.
    pub from_root_m: f64,
}

/// Number of intervals of an edge for which the distance from the root is bounded.
const PIECES: u32 = 16;

impl Cell {
    /// Computes the levers along a path of way points (m, rad; one value per joint).
    ///
    /// # Panics
    /// If a way point has not one value per joint.
    pub fn levers(&self, path: &[Vec<f64>], scratch: &mut Scratch) -> Levers {
        self.levers_with(path, &|_| 0.0, scratch)
    }

    /// Computes the levers at a configuration (m, rad; one per joint) while the hand closes from open, or opens.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn closing_levers(&self, q: &[f64], scratch: &mut Scratch) -> Levers {
        let standing = [q.to_vec(), q.to_vec()];
        self.levers_with(&standing, &|body| self.closing_motion_bound_m(&self.bodies[body]), scratch)
    }

    /// Computes the levers along a path on which every point of a link may be farther away by `farther_m` (m).
    fn levers_with(
        &self,
        path: &[Vec<f64>],
        farther_m: &dyn Fn(usize) -> f64,
        scratch: &mut Scratch,
    ) -> Levers {
        let mut levers = Levers::default();
        for q in path {
            self.robot.forward_kinematics(q, &mut scratch.frames);
            let sums: Vec<Vec<[f64; 2]>> =
                (0..self.bodies.len()).map(|body| self.sums(body, farther_m(body), scratch)).collect();
            let greater = |lever: &mut f64, other: f64| *lever = lever.max(other);
            for sums in &sums {
                greater(&mut levers.turning_m[0], sums[0][0]);
                greater(&mut levers.sliding[0], sums[0][1]);
            }
            for pair in self.pairs.of_links().0 {
                let Other::Link { body, shared_joints } = pair.second else { continue };
                let [first, second] = [&sums[pair.first], &sums[body]].map(|sums| sums[shared_joints]);
                greater(&mut levers.turning_m[1], first[0] + second[0]);
                greater(&mut levers.sliding[1], first[1] + second[1]);
            }
        }
        for edge in path.windows(2) {
            let curve = JointCurve::Line([&edge[0], &edge[1]]);
            scratch.rates.set(curve);
            let half_width = 0.5 / f64::from(PIECES);
            for piece in 0..PIECES {
                self.check_at(curve, (2.0 * f64::from(piece) + 1.0) * half_width, half_width, scratch, 1.0);
                for (index, body) in self.bodies.iter().enumerate() {
                    let center = scratch.frames.link(body.link) * body.bounds.ball.center;
                    let ball_m = body.bounds.ball.radius_m + farther_m(index);
                    let far_m = center.coords.norm() + ball_m + scratch.travel.of(index);
                    levers.from_root_m = levers.from_root_m.max(far_m);
                }
            }
        }
        levers
    }

    /// Returns, for a link, the sums of the levers of its revolute and of its prismatic joints, each from the k-th joint on.
    fn sums(&self, body: usize, farther_m: f64, scratch: &Scratch) -> Vec<[f64; 2]> {
        let body = &self.bodies[body];
        let mut beyond = (scratch.frames.link(body.link) * body.bounds.ball.center).coords;
        let mut way_m = body.bounds.ball.radius_m + farther_m;
        let ancestors = self.robot.ancestors(body.link);
        let mut sums = vec![[0.0; 2]; ancestors.len() + 1];
        for (k, ancestor) in ancestors.iter().enumerate().rev() {
            let origin = scratch.frames.link(ancestor.child_link).translation.vector;
            way_m += (beyond - origin).norm();
            beyond = origin;
            let [turning_m, sliding] = sums[k + 1];
            let rate = ancestor.multiplier.abs();
            sums[k] = match ancestor.kind {
                JointKind::Revolute => [turning_m + rate * way_m, sliding],
                JointKind::Prismatic => [turning_m, sliding + rate],
            };
        }
        sums
    }
}
