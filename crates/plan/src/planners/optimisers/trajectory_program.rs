use cranny_robot::JointLimits;

use crate::planners::optimisers::quadratic_program::QuadraticProgram;

/// Kinds of variables of a trajectory, each with one value per way point and joint.
const KINDS: usize = 4;

/// Constants of the integration of position, velocity, acceleration and jerk over one step, in units of the step.
const HALF: f64 = 0.5;
const SIXTH: f64 = 1.0 / 6.0;

/// Limits of a joint over one step: of position in m or rad, of the others per step, step² and step³; infinite without one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepLimits {
    pub position: [f64; 2],
    pub velocity: f64,
    pub acceleration: f64,
    pub jerk: f64,
}

impl StepLimits {
    /// Returns the limits of a joint with steps of this duration; those of jerk only if `has_jerk`.
    pub fn of(limits: &JointLimits, step_s: f64, has_jerk: bool) -> Self {
        let jerk = limits.jerk.filter(|_| has_jerk);
        Self {
            position: [limits.lower, limits.upper],
            velocity: limits.velocity * step_s,
            acceleration: limits.acceleration.map_or(f64::INFINITY, |most| most * step_s * step_s),
            jerk: jerk.map_or(f64::INFINITY, |most| most * step_s * step_s * step_s),
        }
    }

    /// Returns the least duration of a step in which changes of `by` (m or rad) per step and powers of it keep the limits.
    pub fn least_step_s(
        limits: &JointLimits,
        has_jerk: bool,
        [velocity, acceleration, jerk]: [f64; 3],
    ) -> f64 {
        let of_velocity = velocity / limits.velocity;
        let of_acceleration = limits.acceleration.map_or(0.0, |most| (acceleration / most).sqrt());
        let of_jerk = limits.jerk.filter(|_| has_jerk).map_or(0.0, |most| libm::cbrt(jerk / most));
        of_velocity.max(of_acceleration).max(of_jerk)
    }
}

/// Linear bound on the motion of one way point: `gradient·q ≥ bound`, or a price per unit of its violation.
#[derive(Clone, Debug)]
pub(crate) struct Plane {
    pub way_point: usize,
    pub gradient: Vec<f64>,
    pub bound: f64,
}

/// End of a trajectory.
#[derive(Clone, Debug)]
pub(crate) enum TrajectoryEnd {
    /// One configuration.
    At(Vec<f64>),
    /// Rows `gradient·q = bound`.
    On(Vec<(Vec<f64>, f64)>),
}

/// Program of a trajectory about a known one.
///
/// Variables are positions, velocities, accelerations and jerks of each joint at each way point, with the duration of a step as the
/// unit of time: `q⁺ = q + v + a/2 + j/6`, `v⁺ = v + a + j/2`, `a⁺ = a + j`. The objective is the sum of squared jerks. (Ichnowski et
/// al. 2020, "Deep learning can accelerate grasp-optimized motion planning", Science Robotics 5(48), eqs. 2 to 9, as far as known.)
#[derive(Clone, Debug)]
pub(crate) struct TrajectoryProgram<'a> {
    /// Known trajectory; its first way point is the start.
    pub path: &'a [Vec<f64>],
    pub limits: &'a [StepLimits],
    /// Greatest change of a joint from the known trajectory (m, rad).
    pub trust: f64,
    pub planes: &'a [Plane],
    pub end: &'a TrajectoryEnd,
    /// Price of a violated plane, per metre.
    pub price: f64,
    /// Weight of the sum of squared jerks.
    pub jerk_weight: f64,
}

/// Solved trajectory: positions, velocities, accelerations and jerks by way point, in units of the step.
#[derive(Clone, Debug)]
pub(crate) struct SolvedTrajectory {
    pub kinds: [Vec<Vec<f64>>; KINDS],
    /// Value of the program, with the prices of violated planes.
    pub value: f64,
}

impl TrajectoryProgram<'_> {
    /// Returns the program.
    pub fn program(&self) -> QuadraticProgram {
        let (count, joints) = (self.path.len(), self.limits.len());
        let index = |kind: usize, way_point: usize, joint: usize| (kind * count + way_point) * joints + joint;
        let mut program = QuadraticProgram::new(KINDS * count * joints);
        let last = count - 1;
        for joint in 0..joints {
            let limits = &self.limits[joint];
            for k in 0..last {
                let at = |kind: usize| index(kind, k, joint);
                let next = |kind: usize| index(kind, k + 1, joint);
                program.equal(
                    &[(next(0), 1.0), (at(0), -1.0), (at(1), -1.0), (at(2), -HALF), (at(3), -SIXTH)],
                    0.0,
                );
                program.equal(&[(next(1), 1.0), (at(1), -1.0), (at(2), -1.0), (at(3), -HALF)], 0.0);
                program.equal(&[(next(2), 1.0), (at(2), -1.0), (at(3), -1.0)], 0.0);
                program.add_square(at(3), self.jerk_weight);
            }
            // The last jerk moves nothing.
            program.equal(&[(index(3, last, joint), 1.0)], 0.0);
            program.equal(&[(index(0, 0, joint), 1.0)], self.path[0][joint]);
            for kind in [1, 2] {
                program.equal(&[(index(kind, 0, joint), 1.0)], 0.0);
                program.equal(&[(index(kind, last, joint), 1.0)], 0.0);
            }
            for k in 1..=last {
                if k == last && matches!(self.end, TrajectoryEnd::At(_)) {
                    break;
                }
                let known = self.path[k][joint];
                let lower = limits.position[0].max(known - self.trust);
                let upper = limits.position[1].min(known + self.trust);
                between(&mut program, index(0, k, joint), [lower, upper]);
            }
            for k in 0..=last {
                let bounds = [limits.velocity, limits.acceleration, limits.jerk];
                for (kind, most) in (1..).zip(bounds).filter(|(_, most)| most.is_finite()) {
                    between(&mut program, index(kind, k, joint), [-most, most]);
                }
            }
        }
        match self.end {
            TrajectoryEnd::At(q) => {
                for (joint, value) in q.iter().enumerate() {
                    program.equal(&[(index(0, last, joint), 1.0)], *value);
                }
            }
            TrajectoryEnd::On(rows) => {
                for (gradient, bound) in rows {
                    let row =
                        gradient.iter().enumerate().map(|(joint, slope)| (index(0, last, joint), *slope));
                    program.equal(&row.collect::<Vec<_>>(), *bound);
                }
            }
        }
        for Plane { way_point, gradient, bound } in self.planes {
            let slack = program.add_variable(self.price);
            program.at_most(&[(slack, -1.0)], 0.0);
            let row = gradient.iter().enumerate().map(|(joint, slope)| (index(0, *way_point, joint), -slope));
            program.at_most(&row.chain([(slack, -1.0)]).collect::<Vec<_>>(), -bound);
        }
        program
    }

    /// Solves the program; `None` if there is no such trajectory.
    pub fn solve(&self) -> Option<SolvedTrajectory> {
        let (count, joints) = (self.path.len(), self.limits.len());
        let solution = self.program().solve()?;
        let rows = |kind: usize| {
            let begin = kind * count * joints;
            solution.x[begin..begin + count * joints].chunks(joints).map(<[f64]>::to_vec).collect()
        };
        Some(SolvedTrajectory { kinds: [rows(0), rows(1), rows(2), rows(3)], value: solution.value })
    }
}

fn between(program: &mut QuadraticProgram, variable: usize, [lower, upper]: [f64; 2]) {
    program.at_most(&[(variable, 1.0)], upper);
    program.at_most(&[(variable, -1.0)], -lower);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trajectory_is_optimal_and_keeps_its_limits_and_planes() {
        let path = crate::curves::curve::straight(&[0.0, 0.0], &[1.0, 0.5], 21);
        let limits =
            [StepLimits { position: [-2.0, 2.0], velocity: 0.12, acceleration: 0.02, jerk: 0.01 }; 2];
        // The middle must be above 0.4 in the second joint, where it would be at 0.25.
        let planes = [Plane { way_point: 10, gradient: vec![0.0, 1.0], bound: 0.4 }];
        let program = TrajectoryProgram {
            path: &path,
            limits: &limits,
            trust: 1.0,
            planes: &planes,
            end: &TrajectoryEnd::At(vec![1.0, 0.5]),
            price: 1e3,
            jerk_weight: 1.0,
        };
        let quadratic = program.program();
        let solution = quadratic.solve().expect("a feasible program");
        assert!(quadratic.residual(&solution) <= 1e-6, "{}", quadratic.residual(&solution));
        let found = program.solve().expect("a feasible program");
        let [q, v, a, _] = &found.kinds;
        assert!(q[10][1] >= 0.4 - 1e-6 && (q[20][1] - 0.5).abs() < 1e-6);
        assert!(v.iter().flatten().all(|v| v.abs() <= 0.12 + 1e-6));
        assert!(a.iter().flatten().all(|a| a.abs() <= 0.02 + 1e-6));
        let hurried =
            TrajectoryProgram { limits: &[StepLimits { velocity: 0.04, ..limits[0] }; 2], ..program };
        assert!(hurried.solve().is_none(), "no trajectory is so fast");
    }
}
