use cranny_robot::{Dynamics, Inertial, PathForces, Robot};
use cranny_spatial::Vector;

use crate::PathError;
use crate::timing::path_curve::{PathCurve, Piece};
use crate::timing::piece_limits::PieceLimits;

/// Maximum forces and torques of the drives of a robot, and the masses that they move.
#[derive(Clone, Debug)]
pub struct Drives {
    dynamics: Dynamics,
    /// Effort of each joint, in N or N m.
    efforts: Vec<f64>,
}

/// Share of the limits that trajectories use, as `LIMIT_USE` of `motion_limits.rs`.
const EFFORT_USE: f64 = 1.0 - 1e-6;

/// Maximum share of the effort remaining after gravity for the curvature terms; the rest is for changes of speed.
const SHARE_OF_BEND: f64 = 0.5;

impl Drives {
    /// Creates the drives of a robot, in whose root frame the unit vector `up` points against gravity, with the inertia of a
    /// held object in the frame of the tip.
    ///
    /// # Errors
    /// [`PathError::MissingEffort`] and [`PathError::MissingInertia`].
    pub fn new(robot: &Robot, up: &Vector, held: Option<Inertial>) -> Result<Self, PathError> {
        let effort = |joint: &cranny_robot::GroupJoint| {
            let missing = || PathError::MissingEffort { joint: joint.name.clone() };
            joint.effort.filter(|effort| effort.is_finite()).ok_or_else(missing)
        };
        let efforts = robot.joints().iter().map(effort).collect::<Result<_, _>>()?;
        let dynamics = Dynamics::new(robot, up, held).map_err(|link| PathError::MissingInertia { link })?;
        Ok(Self { dynamics, efforts })
    }

    /// Lowers the limits of each piece of a curve so that no drive exceeds its effort on it.
    ///
    /// With the force `A·s̈ + B·ṡ² + G` of a joint, and A, B and G upper bounds of their absolute values along the piece, a
    /// joint keeps its effort E if `A·|s̈| + B·ṡ² ≤ E − G`.
    ///
    /// # Errors
    /// [`PathError::Weight`] for a joint that may be too weak to support the arm at rest.
    pub(crate) fn limit(
        &self,
        curve: &PathCurve,
        limits: &mut [PieceLimits],
        robot: &Robot,
    ) -> Result<(), PathError> {
        for (piece, limits) in curve.pieces.iter().zip(limits) {
            let [most_u, most_x] = limits.greatest_rates(piece);
            let greatest = self.greatest_forces(piece, robot, [most_u, most_x]);
            let (mut bend_x, mut left) = (most_x, Vec::with_capacity(self.efforts.len()));
            for (joint, effort) in self.efforts.iter().enumerate() {
                let left_n = effort * EFFORT_USE - greatest.weight[joint];
                if left_n.is_nan() || left_n <= 0.0 {
                    return Err(PathError::Weight {
                        joint: robot.joint_names()[joint].clone(),
                        edge: piece.edges[0],
                        needed: greatest.weight[joint],
                        effort: *effort,
                    });
                }
                if greatest.bend[joint] * bend_x > SHARE_OF_BEND * left_n {
                    bend_x = SHARE_OF_BEND * left_n / greatest.bend[joint];
                }
                left.push(left_n);
            }
            let of_joint = |(joint, left_n): (usize, &f64)| {
                (left_n - greatest.bend[joint] * bend_x) / greatest.inertia[joint]
            };
            limits.most_speed = limits.most_speed.min(bend_x.sqrt());
            limits.most_acceleration =
                left.iter().enumerate().map(of_joint).fold(limits.most_acceleration, f64::min);
        }
        Ok(())
    }

    /// Returns upper bounds of the absolute forces along a piece: the maximum over samples δ apart, plus δ/2 times a bound of
    /// the derivative. At the greatest `s̈` and `ṡ²` they exceed the true values by a few per cent of the efforts, unless that
    /// takes more than some thousand samples.
    fn greatest_forces(&self, piece: &Piece, robot: &Robot, [most_u, most_x]: [f64; 2]) -> PathForces {
        const FIRST_SAMPLES: u32 = 8;
        const MOST_SAMPLES: u32 = 8192;
        const EXCESS: f64 = 0.02;
        let joints = 0..self.efforts.len();
        let most: Vec<_> = joints.clone().map(|joint| piece.greatest(joint)).collect();
        let [first, second, third] = [
            most.iter().map(|most| most.first).collect::<Vec<_>>(),
            most.iter().map(|most| most.second).collect(),
            most.iter().map(|most| most.third).collect(),
        ];
        let changes = self.dynamics.changes(robot, [&first, &second, &third]);
        let excess = |joint: usize| {
            let force =
                changes.inertia[joint] * most_u + changes.bend[joint] * most_x + changes.weight[joint];
            force / (EXCESS * self.efforts[joint])
        };
        let wanted = 0.5 * piece.length * joints.clone().map(excess).fold(0.0, f64::max);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let samples = wanted.ceil().clamp(f64::from(FIRST_SAMPLES), f64::from(MOST_SAMPLES)) as u32;
        let apart = piece.length / f64::from(samples);
        let mut frames = robot.frames();
        let mut greatest = PathForces {
            inertia: changes.inertia.iter().map(|change| 0.5 * apart * change).collect(),
            bend: changes.bend.iter().map(|change| 0.5 * apart * change).collect(),
            weight: changes.weight.iter().map(|change| 0.5 * apart * change).collect(),
        };
        let beyond = greatest.clone();
        for sample in 0..samples {
            let s = piece.begin + (f64::from(sample) + 0.5) * apart;
            let at: Vec<_> = joints.clone().map(|joint| piece.derivatives(joint, s)).collect();
            let [first, second] =
                [at.iter().map(|at| at.first).collect::<Vec<_>>(), at.iter().map(|at| at.second).collect()];
            let forces =
                robot.path_forces(&self.dynamics, [&piece.position(s), &first, &second], &mut frames);
            for joint in joints.clone() {
                let raise = |most: &mut f64, force: f64, beyond: f64| *most = most.max(force.abs() + beyond);
                raise(&mut greatest.inertia[joint], forces.inertia[joint], beyond.inertia[joint]);
                raise(&mut greatest.bend[joint], forces.bend[joint], beyond.bend[joint]);
                raise(&mut greatest.weight[joint], forces.weight[joint], beyond.weight[joint]);
            }
        }
        greatest
    }
}
