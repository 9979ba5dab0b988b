use cranny_spatial::{Pose, PoseDifference, Vector};

use crate::{DampedInverse, Jacobian, LinkFrames, Robot, Twist};

/// Settings of inverse kinematics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IkSettings {
    /// Maximum distance of a solution's tip from the target, in metres, above 0. Default 10⁻⁴: a tenth of the tolerance of
    /// `exact`, which leaves a margin for later rounding and smoothing.
    pub translation_tolerance_m: f64,
    /// Maximum angle between a solution's tip and the target, in radians, above 0. Default 10⁻³, for the same reason.
    pub rotation_tolerance_rad: f64,
    /// Maximum number of steps of one attempt. Default 30: on the Panda, successful attempts need 7 on average, and those
    /// that need more than 30 are better restarted.
    pub max_iterations: usize,
    /// Share of the offset from the start configuration that each step removes within the null space of the tip: from 0, no
    /// pull, to 1. Default 0.5.
    pub pull: f64,
}

impl Default for IkSettings {
    fn default() -> Self {
        Self { translation_tolerance_m: 1e-4, rotation_tolerance_rad: 1e-3, max_iterations: 30, pull: 0.5 }
    }
}

/// Configuration that brings the tip to a target.
#[derive(Clone, Debug, PartialEq)]
pub struct IkSolution {
    /// Configuration (m, rad; one per joint), within limits.
    pub q: Vec<f64>,
    /// Distance of the tip from the target, in metres.
    pub translation_error_m: f64,
    /// Rotation of the tip relative to the target, in radians.
    pub rotation_error_rad: f64,
    /// Number of steps.
    pub iterations: usize,
}

/// Inverse kinematics by damped least squares, with its scratch memory.
#[derive(Clone, Debug)]
pub struct IkSolver<'robot> {
    robot: &'robot Robot,
    settings: IkSettings,
    frames: LinkFrames,
    jacobian: Jacobian,
    q: Vec<f64>,
    step: Vec<f64>,
    pull: Vec<f64>,
    is_locked: Vec<bool>,
}

/// Maximum translation of the tip in one step of an attempt, in metres: the linearisation is not valid beyond it.
pub(crate) const MAX_STEP_M: f64 = 0.3;
/// Maximum rotation of the tip in one step of an attempt, in radians.
pub(crate) const MAX_STEP_RAD: f64 = 0.8;
/// Damping λ² = this · (squared error, m² + rad²) + `LEAST_DAMPING` (Sugihara 2011, "Solvability-unconcerned inverse kinematics
/// by the Levenberg-Marquardt method", whole, with this factor added and one weight for all rows): strong far from the target,
/// where a full step would overshoot, and negligible near it, where Newton's method converges quadratically.
pub(crate) const DAMPING_PER_ERROR: f64 = 0.02;
/// Minimum damping λ²: keeps the factorisation positive definite at a singularity; below the squared tolerances.
const LEAST_DAMPING: f64 = 1e-7;
/// Number of steps over which the squared error must fall below [`LEAST_PROGRESS`] of its value, or the attempt fails.
pub(crate) const PATIENCE: usize = 6;
/// Maximum ratio of squared errors that counts as progress (see [`PATIENCE`]).
pub(crate) const LEAST_PROGRESS: f64 = 0.5;
/// Maximum number of computations of one step, repeated when a joint meets its limit.
pub(crate) const LOCK_ROUNDS: usize = 3;

impl<'robot> IkSolver<'robot> {
    /// Returns a solver for the tip of `robot`. Allocates; attempts do not, except for the solution they return.
    pub fn new(robot: &'robot Robot, settings: IkSettings) -> Self {
        let dof = robot.dof();
        Self {
            robot,
            settings,
            frames: robot.frames(),
            jacobian: robot.empty_jacobian(),
            q: vec![0.0; dof],
            step: vec![0.0; dof],
            pull: vec![0.0; dof],
            is_locked: vec![false; dof],
        }
    }

    /// Robot of this solver.
    pub fn robot(&self) -> &'robot Robot {
        self.robot
    }

    /// Makes one attempt from `start` (m, rad; one per joint), clamped into limits, to bring the tip to `root_from_tip`, with
    /// a null-space pull towards `start` (Rudorfer et al. 2024, §V: their method to annotate grasps). `None` if it did not
    /// converge, which does not prove that no solution exists.
    ///
    /// Law: forward kinematics of a solution differ from the target by the errors it states, which are within
    /// tolerance (test `a_solution_reaches_its_target`).
    ///
    /// # Panics
    /// If `start` does not have one value for each joint of the group.
    pub fn solve_from(&mut self, root_from_tip: &Pose, start: &[f64]) -> Option<IkSolution> {
        self.q.copy_from_slice(start);
        self.attempt(root_from_tip, self.settings.pull, Some(start))
    }

    /// Makes one attempt from `start` (m, rad; one per joint), clamped into limits, without a pull. Returns its final
    /// configuration, and true if it reached the target.
    ///
    /// # Panics
    /// As [`Self::solve_from`].
    pub fn approach(&mut self, root_from_tip: &Pose, start: &[f64]) -> (IkSolution, bool) {
        self.q.copy_from_slice(start);
        let reached = self.attempt(root_from_tip, 0.0, None);
        let is_reached = reached.is_some();
        let robot = self.robot;
        let end = reached.unwrap_or_else(|| {
            robot.tip_kinematics(&self.q, &mut self.frames);
            let difference = PoseDifference::between(self.frames.link(robot.tip()), root_from_tip);
            IkSolution {
                q: self.q.clone(),
                translation_error_m: difference.translation_m,
                rotation_error_rad: difference.rotation_rad,
                iterations: self.settings.max_iterations,
            }
        });
        (end, is_reached)
    }

    /// Returns the next configuration (m, rad; one per joint) on a path of the tip: [`Self::solve_from`] the last one, unless
    /// a joint jumps by more than 0.1 (m, rad).
    ///
    /// # Panics
    /// As [`Self::solve_from`].
    pub fn step_from(&mut self, root_from_tip: &Pose, last: &[f64]) -> Option<Vec<f64>> {
        const JUMP: f64 = 0.1;
        let next = self.solve_from(root_from_tip, last)?.q;
        next.iter().zip(last).all(|(a, b)| (a - b).abs() <= JUMP).then_some(next)
    }

    /// Makes one attempt from a random configuration, without a pull; `draw` writes the configuration.
    pub(crate) fn solve_from_drawn(
        &mut self,
        root_from_tip: &Pose,
        draw: impl FnOnce(&mut [f64]),
    ) -> Option<IkSolution> {
        draw(&mut self.q);
        self.attempt(root_from_tip, 0.0, None)
    }

    /// Makes one attempt from `self.q`, and updates it.
    ///
    /// 1. Evaluate the error; the attempt has converged within tolerance, and failed if the error no longer decreases.
    /// 2. Take the damped least-squares step, plus the null-space component of the pull.
    /// 3. If that moves a joint beyond its limits, stop the joint there and recompute the step of the others.
    fn attempt(&mut self, root_from_tip: &Pose, pull: f64, home: Option<&[f64]>) -> Option<IkSolution> {
        let (robot, settings) = (self.robot, self.settings);
        for (value, limits) in self.q.iter_mut().zip(robot.limits()) {
            *value = limits.clamp(*value);
        }
        let (mut reference, mut reference_at) = (f64::INFINITY, 0);
        for iterations in 0..=settings.max_iterations {
            // 1.
            robot.tip_kinematics(&self.q, &mut self.frames);
            let twist = twist_between(self.frames.link(robot.tip()), root_from_tip);
            let (translation_error_m, rotation_error_rad) = (length(&twist, 0), length(&twist, 3));
            if translation_error_m <= settings.translation_tolerance_m
                && rotation_error_rad <= settings.rotation_tolerance_rad
            {
                let difference = PoseDifference::between(self.frames.link(robot.tip()), root_from_tip);
                return Some(IkSolution {
                    q: self.q.clone(),
                    translation_error_m: difference.translation_m,
                    rotation_error_rad: difference.rotation_rad,
                    iterations,
                });
            }
            let error = twist.norm_squared();
            if error < LEAST_PROGRESS * reference {
                (reference, reference_at) = (error, iterations);
            } else if iterations >= reference_at + PATIENCE {
                return None;
            }
            // 2. and 3.
            robot.jacobian(&self.frames, robot.tip(), &mut self.jacobian);
            let shrunk = shrink(twist, translation_error_m, rotation_error_rad);
            // The pull fades with the error, because its second-order motion of the tip would keep the error above zero.
            let fading = pull * error.sqrt().min(1.0);
            self.step_within_limits(&shrunk, DAMPING_PER_ERROR * error + LEAST_DAMPING, fading, home)?;
        }
        None
    }

    fn step_within_limits(
        &mut self,
        twist: &Twist,
        damping_squared: f64,
        pull: f64,
        home: Option<&[f64]>,
    ) -> Option<()> {
        self.is_locked.fill(false);
        for _ in 0..LOCK_ROUNDS {
            let inverse = DampedInverse::new(&self.jacobian, damping_squared.sqrt())?;
            inverse.step(&self.jacobian, twist, &mut self.step);
            if let Some(home) = home {
                for (joint, value) in self.pull.iter_mut().enumerate() {
                    *value = if self.is_locked[joint] { 0.0 } else { pull * (home[joint] - self.q[joint]) };
                }
                inverse.project_to_null_space(&self.jacobian, &mut self.pull);
                self.step.iter_mut().zip(&self.pull).for_each(|(step, pull)| *step += pull);
            }
            // A joint at its limit that would move beyond it is locked: without its column the others compensate.
            let mut is_free = true;
            for (joint, limits) in self.robot.limits().iter().enumerate() {
                let (value, step) = (self.q[joint], self.step[joint]);
                let is_blocked =
                    (value <= limits.lower && step < 0.0) || (value >= limits.upper && step > 0.0);
                if is_blocked && !self.is_locked[joint] {
                    self.is_locked[joint] = true;
                    self.jacobian.column_mut(joint).fill(0.0);
                    is_free = false;
                }
            }
            if is_free {
                break;
            }
        }
        for ((value, step), limits) in self.q.iter_mut().zip(&self.step).zip(self.robot.limits()) {
            *value = limits.clamp(*value + step);
        }
        Some(())
    }
}

/// Returns the motion in the root frame that takes `root_from_a` to `root_from_b`.
fn twist_between(root_from_a: &Pose, root_from_b: &Pose) -> Twist {
    let translation = root_from_b.translation.vector - root_from_a.translation.vector;
    let turn = root_from_b.rotation * root_from_a.rotation.conjugate();
    let imaginary = turn.imag();
    let sine = imaginary.norm();
    // Of the two quaternions of a rotation, the one with w ≥ 0 has the smaller angle.
    let angle = 2.0 * libm::atan2(sine, turn.w.abs());
    let rotation: Vector =
        if sine > 0.0 { imaginary * (angle / sine).copysign(turn.w) } else { Vector::zeros() };
    Twist::new(translation.x, translation.y, translation.z, rotation.x, rotation.y, rotation.z)
}

fn length(twist: &Twist, first_row: usize) -> f64 {
    twist.fixed_rows::<3>(first_row).norm()
}

/// Scales `twist` so that neither its translation nor its rotation exceeds the maximum step.
fn shrink(twist: Twist, translation_m: f64, rotation_rad: f64) -> Twist {
    let excess = (translation_m / MAX_STEP_M).max(rotation_rad / MAX_STEP_RAD);
    if excess > 1.0 { twist / excess } else { twist }
}
