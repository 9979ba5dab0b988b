use cranny_robot::{JointKind, LinkFrames, Robot};

use crate::link_body::LinkBody;

/// How far the links can move while the configuration runs along a straight edge.
///
/// Let the edge be `q(t)`, with slope `Δq`, and let `h` be how far `t` strays from the configuration whose
/// frames are given. A point of a link moves at most at `Σ_j |Δq_j| · r_j` per unit of `t`, with `r_j` its
/// distance from the axis of joint j (1 for a prismatic joint). That distance itself changes only by joints
/// beyond j, so from the tip to the root
///
/// `r_j ≤ r_j(now) + h · Σ_{k beyond j} |Δq_k| · r_k`,
///
/// and `h · Σ_j |Δq_j| · r_j` bounds the motion over the whole interval (after Schwarzer, Saha & Latombe
/// 2005, §3, with the reach taken at the configuration instead of over all of them).
#[derive(Clone, Debug, Default)]
pub(crate) struct Travel {
    /// For each link body the sums over the joints from the k-th on, each already times `h`; one longer
    /// than the link has joints.
    sums: Vec<Vec<f64>>,
}

impl Travel {
    pub fn new(robot: &Robot, bodies: &[LinkBody]) -> Self {
        Self { sums: bodies.iter().map(|b| vec![0.0; robot.ancestors(b.link).len() + 1]).collect() }
    }

    /// Bounds the motion of every link within `half_width` (of `t`) of the configuration of `frames`.
    /// `factor` is 1; the tests set it lower to see that a wrong bound is caught.
    pub fn update(
        &mut self,
        robot: &Robot,
        bodies: &[LinkBody],
        frames: &LinkFrames,
        slope: &[f64],
        half_width: f64,
        factor: f64,
    ) {
        for index in 0..bodies.len() {
            self.update_body(robot, bodies, index, frames, slope, half_width * factor);
        }
    }

    /// The same for one link body.
    pub fn update_body(
        &mut self,
        robot: &Robot,
        bodies: &[LinkBody],
        index: usize,
        frames: &LinkFrames,
        slope: &[f64],
        half_width: f64,
    ) {
        let (body, sums) = (&bodies[index], &mut self.sums[index]);
        let center = frames.link(body.link) * body.bounds.ball.center;
        let mut sum = 0.0;
        for (k, ancestor) in robot.ancestors(body.link).iter().enumerate().rev() {
            let speed = (slope[ancestor.joint] * ancestor.multiplier).abs();
            if speed <= 0.0 {
                sums[k] = sum;
                continue;
            }
            let reach = match ancestor.kind {
                JointKind::Prismatic => 1.0,
                JointKind::Revolute => {
                    let joint = frames.link(ancestor.child_link);
                    let axis = joint.rotation * ancestor.axis_in_child;
                    let arm = center.coords - joint.translation.vector;
                    axis.cross(&arm).norm() + body.bounds.ball.radius_m + sum
                }
            };
            sum += half_width * speed * reach;
            sums[k] = sum;
        }
    }

    /// How far any point of the link can move against the world, in metres.
    pub fn of(&self, body: usize) -> f64 {
        self.sums[body][0]
    }

    /// How far any point of one link can move against the other, in metres, when their first
    /// `shared_joints` joints are the same.
    pub fn between(&self, first: usize, second: usize, shared_joints: usize) -> f64 {
        self.sums[first][shared_joints] + self.sums[second][shared_joints]
    }
}

/// How many joints, from the root on, move both links alike.
pub(crate) fn shared_joints(robot: &Robot, first: usize, second: usize) -> usize {
    let (a, b) = (robot.ancestors(first), robot.ancestors(second));
    a.iter().zip(b).take_while(|(x, y)| x.child_link == y.child_link).count()
}
