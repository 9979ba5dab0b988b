use cranny_robot::{JointKind, LinkFrames, Robot};
use cranny_spatial::Vector;

use crate::body::link_body::LinkBody;
use crate::proof::joint_curve::Rates;

/// Bounds on the motion of the links while the configuration runs along a motion.
///
/// Let the motion be `q(t)`, with `|q'| ≤ Δq` (constant on a straight edge) and `|q''| ≤ β` (0 there), and let `h` be the
/// maximum deviation of `t` from the configuration of the given frames. The smaller one of two bounds applies.
///
/// 1. By levers: a point of a link moves at most at `Σ_j a_j` per unit of `t`, `a_j = |Δq_j| · r_j`, with `r_j` its distance
///    from the axis of joint j (1 for a prismatic joint). Only joints beyond j change that distance,
///    `r_j ≤ r_j(now) + h · Σ_{k beyond j} a_k`, and it never exceeds the length to the point through the origins of the joints
///    beyond j (after Schwarzer, Saha & Latombe 2005, §3, with the reach at the configuration instead of over all of them).
/// 2. By velocity: the effects of the joints on a point largely cancel. With `v` and `ω` the present velocity of the centre of
///    the ball around the link and its angular velocity, `ρ` the ball's radius, and accelerations bounded by
///    `α = Σ_j |Δq_j| · (a_j + 2 · Σ_{k beyond j} a_k)` over the revolute joints, plus `Σ_j β_j · r_j` over all (1 for `r_j` of
///    a prismatic joint), no point moves farther than `h · (|v| + |ω| · ρ) + ½ h² · α` (a Taylor model of first order, after
///    Zhang, Redon, Lee & Kim 2007, "Continuous collision detection for articulated models using Taylor models and temporal
///    culling", whole; α is derived below).
///
/// The acceleration of a point `p` beyond joints with axes `z_j` through `o_j` is the sum over j of
/// `Δq_j · (ω_{j-1} × (z_j × (p − o_j)) + z_j × Σ_{k ≥ j} Δq_k · z_k × (p − o_k)) + q_j'' · z_j × (p − o_j)`, which gives α.
#[derive(Clone, Debug, Default)]
pub(crate) struct Travel {
    /// Sums of the first bound of each link over the joints from the k-th on, each multiplied by `h`; one more entry than the
    /// link has joints.
    sums: Vec<Vec<f64>>,
    /// Bounds on the velocity of each link.
    link_speeds: Vec<LinkSpeed>,
    travels_m: Vec<f64>,
    /// True if the bounds of a link have been computed since [`Self::forget`].
    is_known: Vec<bool>,
    /// Axis of the joint of each link, if it has been computed.
    axes: Vec<Option<Axis>>,
}

/// Axis of a joint, in the root frame.
#[derive(Clone, Copy, Debug)]
struct Axis {
    direction: Vector,
    origin: Vector,
}

/// Bounds on the motion of a link, per unit of `t`, in metres.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LinkSpeed {
    /// Maximum velocity of any of its points within the interval.
    pub most: f64,
    /// Maximum velocity of any of its points at the configuration itself.
    pub now: f64,
    /// Maximum acceleration of any of its points within the interval.
    pub acceleration: f64,
}

impl LinkSpeed {
    /// Returns a bound on the motion of any point, for `t` up to `half_width` away, in metres.
    fn travel_m(&self, half_width: f64) -> f64 {
        half_width * self.most.min(self.now + 0.5 * half_width * self.acceleration)
    }
}

impl Travel {
    pub fn new(robot: &Robot, bodies: &[LinkBody]) -> Self {
        Self {
            sums: bodies.iter().map(|b| vec![0.0; robot.ancestors(b.link).len() + 1]).collect(),
            link_speeds: vec![LinkSpeed::default(); bodies.len()],
            travels_m: vec![0.0; bodies.len()],
            is_known: vec![false; bodies.len()],
            axes: vec![None; robot.links().len()],
        }
    }

    /// Computes the bounds on the motion of every link within `half_width` (of `t`) of the configuration of `frames`. `factor`
    /// is 1; tests lower it to verify that a wrong bound is detected.
    pub fn update(
        &mut self,
        robot: &Robot,
        bodies: &[LinkBody],
        frames: &LinkFrames,
        rates: &Rates,
        half_width: f64,
        factor: f64,
    ) {
        self.forget();
        for index in 0..bodies.len() {
            self.know(robot, bodies, index, frames, rates, half_width * factor);
        }
    }

    /// Invalidates the cached bounds, for other frames or another interval.
    pub fn forget(&mut self) {
        self.is_known.fill(false);
        self.axes.fill(None);
    }

    /// Computes and caches the motion bound of the link with geometry of this index.
    pub fn know(
        &mut self,
        robot: &Robot,
        bodies: &[LinkBody],
        index: usize,
        frames: &LinkFrames,
        rates: &Rates,
        half_width: f64,
    ) {
        if std::mem::replace(&mut self.is_known[index], true) {
            return;
        }
        let (body, sums) = (&bodies[index], &mut self.sums[index]);
        let center = (frames.link(body.link) * body.bounds.ball.center).coords;
        let radius_m = body.bounds.ball.radius_m;
        let (mut velocity, mut turn, mut link_speed) =
            (Vector::zeros(), Vector::zeros(), LinkSpeed::default());
        // Origin of the joint beyond, and maximum length from the current joint through these origins to a point of the link.
        let (mut beyond, mut way_m) = (center, radius_m);
        for (k, ancestor) in robot.ancestors(body.link).iter().enumerate().rev() {
            let rate = rates.now[ancestor.joint] * ancestor.multiplier;
            let [speed, bend] = [rates.most_of(ancestor.joint), rates.bend_of(ancestor.joint)]
                .map(|most| most * ancestor.multiplier.abs());
            if speed > 0.0 {
                let known = &mut self.axes[ancestor.child_link];
                let Axis { direction: axis, origin } = *known.get_or_insert_with(|| {
                    let joint = frames.link(ancestor.child_link);
                    let direction = joint.rotation * ancestor.axis_in_child;
                    Axis { direction, origin: joint.translation.vector }
                });
                way_m += (beyond - origin).norm();
                beyond = origin;
                link_speed.most += speed
                    * match ancestor.kind {
                        JointKind::Prismatic => {
                            way_m += half_width * speed;
                            velocity += axis * rate;
                            link_speed.acceleration += bend;
                            1.0
                        }
                        JointKind::Revolute => {
                            let arm = axis.cross(&(center - origin));
                            let reach = (arm.norm() + radius_m + half_width * link_speed.most).min(way_m);
                            velocity += arm * rate;
                            turn += axis * rate;
                            link_speed.acceleration +=
                                speed * (speed * reach + 2.0 * link_speed.most) + bend * reach;
                            reach
                        }
                    };
            }
            sums[k] = half_width * link_speed.most;
        }
        link_speed.now = velocity.norm() + turn.norm() * radius_m;
        self.link_speeds[index] = link_speed;
        self.travels_m[index] = link_speed.travel_m(half_width);
    }

    /// Returns the bounds on the velocity of a link against the world.
    pub fn link_speed(&self, body: usize) -> LinkSpeed {
        self.link_speeds[body]
    }

    /// Returns the bound on the motion of any point of the link against the world, in metres.
    pub fn of(&self, body: usize) -> f64 {
        self.travels_m[body]
    }

    /// Returns the bound on the motion of any point of one link against the other, in metres, if their first `shared_joints`
    /// joints are the same.
    pub fn between(&self, first: usize, second: usize, shared_joints: usize) -> f64 {
        self.sums[first][shared_joints] + self.sums[second][shared_joints]
    }
}

/// Returns the number of joints, from the root on, that move both links alike.
pub(crate) fn shared_joints(robot: &Robot, first: usize, second: usize) -> usize {
    let (a, b) = (robot.ancestors(first), robot.ancestors(second));
    a.iter().zip(b).take_while(|(x, y)| x.child_link == y.child_link).count()
}
