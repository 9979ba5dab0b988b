use cranny_robot::{JointKind, Robot};
use cranny_spatial::Vector;
use cranny_task::SpeedLimits;

use crate::timing::motion_limits::MotionLimits;
use crate::timing::path_curve::{PathCurve, Piece};

/// Limits on one piece of a curve.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PieceLimits {
    /// Velocity limit of each joint, in its unit/s.
    pub velocity: Vec<f64>,
    /// Acceleration limit of each joint, in its unit/s².
    pub acceleration: Vec<f64>,
    /// Jerk limit of each joint, in its unit/s³; infinite if jerk is not limited.
    pub jerk: Vec<f64>,
    /// Maximum `ṡ`.
    pub most_speed: f64,
    /// Maximum absolute value of `s̈`.
    pub most_acceleration: f64,
}

/// Limits of an edge of a path in addition to the joint limits.
#[derive(Clone, Copy, Debug)]
pub struct EdgePace {
    /// Requested limits.
    pub pace: SpeedLimits,
    /// Speed factor: velocities, including that of the tool, scale with it, accelerations with its square, jerks with its cube.
    pub share: f64,
}

impl Default for EdgePace {
    fn default() -> Self {
        Self { pace: SpeedLimits::default(), share: 1.0 }
    }
}

impl PieceLimits {
    /// Returns the limits of each piece of a curve, given the paces of the edges of its path (none: no further limits).
    pub fn all_of(
        curve: &PathCurve,
        limits: &MotionLimits,
        paces: &[EdgePace],
        robot: Option<&Robot>,
    ) -> Vec<Self> {
        curve.pieces.iter().map(|piece| Self::of(piece, limits, paces, robot)).collect()
    }

    fn of(piece: &Piece, limits: &MotionLimits, paces: &[EdgePace], robot: Option<&Robot>) -> Self {
        let of_edge = |edge: usize| paces.get(edge).copied().unwrap_or_default();
        let both = piece.edges.map(of_edge);
        let least = |of: fn(&EdgePace) -> f64| of(&both[0]).min(of(&both[1]));
        let velocity = least(|edge| edge.share * edge.pace.velocity);
        let acceleration = least(|edge| edge.share.powi(2) * edge.pace.acceleration);
        let jerk = least(|edge| edge.share.powi(3));
        let times = |limits: &[f64], share: f64| limits.iter().map(|limit| limit * share).collect();
        let slowest = |of: fn(&SpeedLimits) -> Option<f64>| {
            both.iter().filter_map(|edge| Some(edge.share * of(&edge.pace)?)).reduce(f64::min)
        };
        let most_speed = |speed: Option<f64>, greatest: fn(&Robot, &Piece) -> f64| {
            let most = speed.zip(robot).map(|(speed, robot)| speed / greatest(robot, piece));
            most.filter(|most| most.is_finite()).unwrap_or(f64::INFINITY)
        };
        let most_speed = most_speed(slowest(|pace| pace.tool_m_s), greatest_tool_slope)
            .min(most_speed(slowest(|pace| pace.turn_rad_s), greatest_turn_slope));
        Self {
            velocity: times(&limits.velocity, velocity),
            acceleration: times(&limits.acceleration, acceleration),
            jerk: if limits.jerk.is_empty() {
                vec![f64::INFINITY; limits.velocity.len()]
            } else {
                times(&limits.jerk, jerk)
            },
            most_speed,
            most_acceleration: f64::INFINITY,
        }
    }

    /// Returns the greatest `|s̈|` and `ṡ²` on a piece under the joint limits.
    pub fn greatest_rates(&self, piece: &Piece) -> [f64; 2] {
        let rates = (0..self.velocity.len()).map(|joint| (piece.greatest(joint), joint));
        let of_joint = rates.map(|(most, joint)| {
            let [velocity, acceleration, _] = self.of_joint(joint);
            [acceleration / most.first, (velocity / most.first).powi(2)]
        });
        of_joint.fold([self.most_acceleration, self.most_speed.powi(2)], |[u, x], [of_u, of_x]| {
            [u.min(of_u), x.min(of_x)]
        })
    }

    /// Returns the limits of velocity, acceleration and jerk of a joint.
    pub fn of_joint(&self, joint: usize) -> [f64; 3] {
        [self.velocity[joint], self.acceleration[joint], self.jerk[joint]]
    }
}

/// Returns an upper bound of `|dp/ds|` of the origin of the gripper frame along a piece, in metres per unit of `s`, by
/// [`greatest_slope`] with `|d²p/ds²| ≤ Σ_i Σ_j |q_i'| |q_j'| r + Σ_j |q_j''| r`, where r bounds the distance of the origin
/// from every axis of a revolute joint (`∂²p/∂q_i∂q_j = a_i × (a_j × (p − o_j))`).
fn greatest_tool_slope(robot: &Robot, piece: &Piece) -> f64 {
    /// Step of the difference quotient, as a share of the piece.
    const STEP: f64 = 1e-5;
    let [first, second] = rate_sums(piece);
    let mut frames = robot.frames();
    let mut tip = |s: f64| {
        robot.tip_kinematics(&piece.position(s), &mut frames);
        frames.link(robot.tip()).translation.vector
    };
    let step = STEP * piece.length;
    let slope = |s: f64| (tip(s + step) - tip(s - step)).norm() / (2.0 * step);
    greatest_slope(piece, (first * first + second) * tip_reach_m(robot), slope)
}

/// Returns an upper bound of the rate `|ω|`, `ω = Σ_j q_j' a_j`, at which the gripper frame turns along a piece, in radians per
/// unit of `s`, by [`greatest_slope`] with `|dω/ds| ≤ Σ_i Σ_j |q_i'| |q_j'| + Σ_j |q_j''|`.
fn greatest_turn_slope(robot: &Robot, piece: &Piece) -> f64 {
    let movers = robot.ancestors(robot.tip());
    let most = movers.iter().map(|mover| mover.multiplier.abs()).fold(1.0, f64::max);
    let [first, second] = rate_sums(piece).map(|sum| sum * most);
    let mut frames = robot.frames();
    let turn = |s: f64| {
        robot.tip_kinematics(&piece.position(s), &mut frames);
        let turns = movers.iter().filter(|mover| mover.kind == JointKind::Revolute).map(|mover| {
            let rate = mover.multiplier * piece.derivatives(mover.joint, s).first;
            frames.link(mover.child_link).rotation * mover.axis_in_child * rate
        });
        turns.sum::<Vector>().norm()
    };
    greatest_slope(piece, first * first + second, turn)
}

/// Returns the sums of the greatest absolute first and second derivatives of all joints along a piece.
fn rate_sums(piece: &Piece) -> [f64; 2] {
    let most = (0..piece.slope.len()).map(|joint| piece.greatest(joint));
    most.fold([0.0; 2], |[first, second], most| [first + most.first, second + most.second])
}

/// Returns an upper bound of a slope along a piece, at most 1 % above the true value unless that takes more than 1024 samples:
/// the greatest sample plus δ/2 times `bend`, a bound of the derivative of the slope, with samples δ apart.
fn greatest_slope(piece: &Piece, bend: f64, mut slope: impl FnMut(f64) -> f64) -> f64 {
    const MOST_SAMPLES: u32 = 1024;
    const EXCESS: f64 = 0.01;
    let mut samples = 8;
    loop {
        let apart = piece.length / f64::from(samples);
        let mut greatest = 0.0_f64;
        for k in 0..samples {
            greatest = greatest.max(slope(piece.begin + (f64::from(k) + 0.5) * apart));
        }
        let beyond = 0.5 * apart * bend + 1e-6 * greatest;
        if beyond <= EXCESS * greatest || samples >= MOST_SAMPLES || greatest == 0.0 {
            return greatest + beyond;
        }
        samples *= 4;
    }
}

/// Returns an upper bound of the distance of the origin of the gripper frame from the axis of any revolute joint, times the
/// multiplier of the joint, at any configuration, in metres; at least 1, for prismatic joints.
fn tip_reach_m(robot: &Robot) -> f64 {
    let frames = robot.frames_at(&vec![0.0; robot.dof()]);
    let origin = |link: usize| frames.link(link).translation.vector;
    let (mut distance_m, mut beyond, mut most_m) = (0.0, origin(robot.tip()), 1.0_f64);
    for mover in robot.ancestors(robot.tip()).iter().rev() {
        distance_m += (beyond - origin(mover.child_link)).norm();
        beyond = origin(mover.child_link);
        let scale = mover.multiplier.abs();
        match mover.kind {
            JointKind::Revolute => most_m = most_m.max(distance_m * scale * scale.max(1.0)),
            JointKind::Prismatic => {
                let limits = &robot.limits()[mover.joint];
                distance_m += scale * limits.lower.abs().max(limits.upper.abs());
                most_m = most_m.max(scale * scale.max(1.0));
            }
        }
    }
    most_m
}
