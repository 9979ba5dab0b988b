use cranny_spatial::{LANES, LaneArray, Pose, simd_level};
use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x16, mask32x16};

use crate::chain::lane_chain::{LaneChain, Offset, Tip, cross, narrow};
use crate::ik::inverse_kinematics::{
    DAMPING_PER_ERROR, LEAST_PROGRESS, LOCK_ROUNDS, MAX_STEP_M, MAX_STEP_RAD, PATIENCE,
};
use crate::{IkSettings, Robot};

/// Minimum damping λ². It keeps the factorisation positive definite in `f32`, whose rounding of the Panda's Gram matrix is
/// about 10⁻⁶; it exceeds that in `f64`, which costs a few steps near a singularity.
const LEAST_DAMPING: f32 = 1e-5;
/// Minimum pivot of a factorisation: the remainder of `LEAST_DAMPING` after rounding.
const LEAST_PIVOT: f32 = 1e-6;
/// Factor on the tolerances at which lanes stop, so that their results are within tolerance in `f64` too: the two poses
/// differ by a few 10⁻⁶ m and rad.
const PART_OF_TOLERANCE: f64 = 0.8;
/// Minimum tolerance in the lanes (m, rad): several times the rounding error; `f64` steps reach tighter tolerances.
const LEAST_TOLERANCE: f64 = 2e-5;
/// Maximum number of steps of a batch. It lasts as long as its slowest attempt, so a long one is given up earlier than
/// a single one; 97 of 100 successful attempts on the Panda need no more.
const MAX_ITERATIONS: usize = 12;
/// Minimum sine of a rotation whose axis is not lost to rounding: below it, the rotation is within any tolerance, or so
/// near a half turn that the direction of the step is arbitrary.
const LEAST_SINE: f32 = 1e-6;

/// Damped least squares from 16 starts at once, one per SIMD lane, in `f32`: the steps of [`crate::IkSolver`] without a pull.
///
/// Every instruction set adds, multiplies, divides and takes roots in the same order, without fused operations, so all
/// give the same bits; no lane depends on another.
#[derive(Clone, Debug)]
pub(crate) struct IkLanes {
    chain: LaneChain,
    /// Lower and upper limit of each joint.
    limits: Vec<[f32; 2]>,
    /// Squared tolerances, in m² and rad².
    tolerance_squared: [f32; 2],
    max_iterations: usize,
    /// One row of lanes per joint.
    q: Vec<LaneArray>,
    /// Rotation matrix, row by row, and translation of each target.
    targets: [LaneArray; 12],
    /// One bit per attempt.
    reached: u64,
    iterations: LaneArray,
    jacobian: Vec<[LaneArray; 6]>,
    steps: Vec<LaneArray>,
}

impl IkLanes {
    /// Returns lanes for the robot's tip; `settings.pull` is ignored.
    pub fn new(robot: &Robot, settings: &IkSettings) -> Self {
        let square = |tolerance: f64| narrow((PART_OF_TOLERANCE * tolerance).max(LEAST_TOLERANCE).powi(2));
        Self {
            chain: LaneChain::new(robot),
            limits: robot
                .limits()
                .iter()
                .map(|limits| [narrow(limits.lower), narrow(limits.upper)])
                .collect(),
            tolerance_squared: [
                square(settings.translation_tolerance_m),
                square(settings.rotation_tolerance_rad),
            ],
            max_iterations: settings.max_iterations.min(MAX_ITERATIONS),
            q: vec![[0.0; LANES]; robot.dof()],
            targets: [[0.0; LANES]; 12],
            reached: 0,
            iterations: [0.0; LANES],
            jacobian: vec![[[0.0; LANES]; 6]; robot.dof()],
            steps: vec![[0.0; LANES]; robot.dof()],
        }
    }

    /// Sets the start of attempt `lane` (m, rad; one per joint), clamped into limits, and the target of its tip.
    pub fn set(&mut self, lane: usize, root_from_tip: &Pose, start: &[f64]) {
        for ((q, &value), [lower, upper]) in self.q.iter_mut().zip(start).zip(&self.limits) {
            q[lane] = narrow(value).max(*lower).min(*upper);
        }
        let target = Offset::of(root_from_tip);
        let numbers = target.rotation.as_flattened().iter().chain(&target.translation);
        for (lanes, number) in self.targets.iter_mut().zip(numbers) {
            lanes[lane] = *number;
        }
    }

    /// Runs the first `count` attempts, at most [`LANES`], until each has converged or failed.
    pub fn run(&mut self, count: usize) {
        self.run_at(simd_level(), count);
    }

    fn run_at(&mut self, level: Level, count: usize) {
        dispatch!(level, simd => self.attempt(simd, count));
    }

    /// Returns true if attempt `lane` of the last run reached its target.
    pub fn is_reached(&self, lane: usize) -> bool {
        self.reached >> lane & 1 == 1
    }

    /// Returns the final configuration of attempt `lane` of the last run.
    pub fn q(&self, lane: usize) -> impl Iterator<Item = f64> {
        self.q.iter().map(move |lanes| f64::from(lanes[lane]))
    }

    /// Number of steps of attempt `lane` of the last run, if it reached its target.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count that is not negative and small"
    )]
    pub fn iterations(&self, lane: usize) -> usize {
        self.iterations[lane] as usize
    }

    /// 1. Evaluate the errors; an attempt has converged within tolerance, and failed if the error no longer decreases.
    /// 2. Take the damped least-squares step of those still running.
    #[inline(always)]
    fn attempt<S: Simd>(&mut self, simd: S, count: usize) {
        let mut is_running = mask32x16::from_bitmask(simd, (1 << count) - 1);
        let mut is_reached = mask32x16::splat(simd, false);
        let mut reference = f32x16::splat(simd, f32::INFINITY);
        let mut reference_at = f32x16::splat(simd, 0.0);
        let mut iterations = reference_at;
        let mut now = 0.0;
        for _ in 0..=self.max_iterations {
            // 1.
            let tip = self.chain.tip(simd, &self.q);
            let (twist, translation_squared, rotation_squared) = self.twist(simd, &tip);
            let is_there = translation_squared.simd_le(self.tolerance_squared[0])
                & rotation_squared.simd_le(self.tolerance_squared[1])
                & is_running;
            is_reached |= is_there;
            iterations = is_there.select(f32x16::splat(simd, now), iterations);
            let error = translation_squared + rotation_squared;
            let is_better = error.simd_lt(reference * narrow(LEAST_PROGRESS));
            reference = is_better.select(error, reference);
            reference_at = is_better.select(f32x16::splat(simd, now), reference_at);
            let is_lost = reference_at.simd_le(now - PATIENCE as f32);
            is_running &= !(is_there | is_lost);
            if is_running.all_false() {
                break;
            }
            // 2.
            self.chain.jacobian(simd, &tip, &mut self.jacobian);
            let damping_squared = error * narrow(DAMPING_PER_ERROR) + LEAST_DAMPING;
            self.step(simd, &twist, damping_squared, is_running);
            now += 1.0;
        }
        self.reached = is_reached.to_bitmask();
        iterations.store_slice(&mut self.iterations);
    }

    /// Returns the motion that takes each tip to its target, limited to the maximum step, and its squared translation and
    /// rotation before that, in m² and rad².
    ///
    /// The length of the rotation approximates its angle only for small angles; large ones are only ordered correctly.
    #[inline(always)]
    fn twist<S: Simd>(&self, simd: S, tip: &Tip<S>) -> ([f32x16<S>; 6], f32x16<S>, f32x16<S>) {
        let target = |index: usize| f32x16::from_slice(simd, &self.targets[index]);
        let half = f32x16::splat(simd, 0.5);
        let one = f32x16::splat(simd, 1.0);
        let zero = f32x16::splat(simd, 0.0);
        let mut twist = [zero; 6];
        let mut translation_squared = zero;
        for (row, difference) in twist[..3].iter_mut().enumerate() {
            *difference = target(9 + row) - tip.translation[row];
            translation_squared += *difference * *difference;
        }
        // Half the sum of the cross products of the axes is the sine times the axis of the rotation between them.
        let mut twice_cosine = -one;
        for axis in 0..3 {
            let a: [f32x16<S>; 3] = std::array::from_fn(|row| tip.rotation[row][axis]);
            let b: [f32x16<S>; 3] = std::array::from_fn(|row| target(3 * row + axis));
            twice_cosine += a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            for (row, part) in cross(a, b).into_iter().enumerate() {
                twist[3 + row] += part * half;
            }
        }
        let sine_squared = twist[3] * twist[3] + twist[4] * twist[4] + twist[5] * twist[5];
        let sine = sine_squared.sqrt();
        // A cubic through the angles 0 and ½π, mirrored at ½π, approximates the angle.
        const CUBIC: f32 = std::f32::consts::FRAC_PI_2 - 1.0;
        let folded = sine * (sine_squared * CUBIC + 1.0);
        let is_obtuse = twice_cosine.simd_lt(0.0);
        let angle = is_obtuse.select(f32x16::splat(simd, std::f32::consts::PI) - folded, folded);
        let is_turned = sine.simd_gt(LEAST_SINE);
        let scale = is_turned.select(angle / sine.max(LEAST_SINE), one);
        let excess = (translation_squared.sqrt() * narrow(1.0 / MAX_STEP_M))
            .max(angle * narrow(1.0 / MAX_STEP_RAD))
            .max(1.0);
        let shrink = one / excess;
        for (index, part) in twist.iter_mut().enumerate() {
            *part = if index < 3 { *part * shrink } else { *part * scale * shrink };
        }
        (twist, translation_squared, angle * angle)
    }

    /// Takes one step of the running attempts; a joint at its limit that would move beyond it is locked.
    #[inline(always)]
    fn step<S: Simd>(
        &mut self,
        simd: S,
        twist: &[f32x16<S>; 6],
        damping_squared: f32x16<S>,
        is_running: mask32x16<S>,
    ) {
        let zero = f32x16::splat(simd, 0.0);
        for round in 0..LOCK_ROUNDS {
            let weights = solve(simd, &self.jacobian, damping_squared, twist);
            let mut is_any_blocked = mask32x16::splat(simd, false);
            for (joint, (column, step)) in self.jacobian.iter_mut().zip(&mut self.steps).enumerate() {
                let mut sum = zero;
                for (lanes, weight) in column.iter().zip(&weights) {
                    sum += f32x16::from_slice(simd, lanes) * *weight;
                }
                sum.store_slice(step);
                if round + 1 == LOCK_ROUNDS {
                    continue;
                }
                let q = f32x16::from_slice(simd, &self.q[joint]);
                let [lower, upper] = self.limits[joint];
                let is_blocked = ((q.simd_le(lower) & sum.simd_lt(0.0))
                    | (q.simd_ge(upper) & sum.simd_gt(0.0)))
                    & is_running;
                if is_blocked.any_true() {
                    is_any_blocked |= is_blocked;
                    for lanes in column {
                        is_blocked.select(zero, f32x16::from_slice(simd, lanes)).store_slice(lanes);
                    }
                }
            }
            if is_any_blocked.all_false() {
                break;
            }
        }
        for ((q, step), [lower, upper]) in self.q.iter_mut().zip(&self.steps).zip(&self.limits) {
            let from = f32x16::from_slice(simd, q);
            let to = (from + f32x16::from_slice(simd, step)).max(*lower).min(*upper);
            is_running.select(to, from).store_slice(q);
        }
    }
}

/// Solves `(JJᵀ + λ²I)⁻¹ v` by Cholesky factorisation.
#[inline(always)]
fn solve<S: Simd>(
    simd: S,
    jacobian: &[[LaneArray; 6]],
    damping_squared: f32x16<S>,
    twist: &[f32x16<S>; 6],
) -> [f32x16<S>; 6] {
    let zero = f32x16::splat(simd, 0.0);
    let mut lower = [[zero; 6]; 6];
    for (i, row) in lower.iter_mut().enumerate() {
        row[i] = damping_squared;
    }
    for column in jacobian {
        let column: [f32x16<S>; 6] = std::array::from_fn(|row| f32x16::from_slice(simd, &column[row]));
        for i in 0..6 {
            for k in 0..=i {
                lower[i][k] += column[i] * column[k];
            }
        }
    }
    let one = f32x16::splat(simd, 1.0);
    let mut inverse_pivots = [zero; 6];
    for i in 0..6 {
        for k in 0..=i {
            let mut entry = lower[i][k];
            for (a, b) in lower[i].iter().zip(&lower[k]).take(k) {
                entry -= *a * *b;
            }
            if k == i {
                inverse_pivots[i] = one / entry.max(LEAST_PIVOT).sqrt();
            } else {
                lower[i][k] = entry * inverse_pivots[k];
            }
        }
    }
    let mut weights = *twist;
    for i in 0..6 {
        for k in 0..i {
            weights[i] -= lower[i][k] * weights[k];
        }
        weights[i] *= inverse_pivots[i];
    }
    for i in (0..6).rev() {
        for k in i + 1..6 {
            weights[i] -= lower[k][i] * weights[k];
        }
        weights[i] *= inverse_pivots[i];
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RobotOptions;
    use cranny_spatial::{Stream, simd_levels};

    fn robot() -> Robot {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("tests/fixtures/mobile_arm/mobile_arm.urdf");
        Robot::load(&file, &RobotOptions::default()).expect("the fixture is a robot")
    }

    /// Returns lanes whose attempts have random starts and reachable targets.
    fn drawn(robot: &Robot, random: &mut Stream) -> IkLanes {
        let mut lanes = IkLanes::new(robot, &IkSettings::default());
        let mut frames = robot.frames();
        let mut draw = || -> Vec<f64> { robot.random_configuration(random) };
        for lane in 0..LANES {
            robot.forward_kinematics(&draw(), &mut frames);
            lanes.set(lane, frames.link(robot.tip()), &draw());
        }
        lanes
    }

    /// Returns the outcome of an attempt: true if it reached its target, its steps, and the bits of its final configuration.
    fn ends(lanes: &IkLanes, lane: usize) -> (bool, usize, Vec<u64>) {
        (lanes.is_reached(lane), lanes.iterations(lane), lanes.q(lane).map(f64::to_bits).collect())
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let robot = robot();
        let mut random = Stream::new(21, 0);
        let mut reached = 0;
        for _ in 0..100 {
            let drawn = drawn(&robot, &mut random);
            let ended: Vec<_> = simd_levels()
                .into_iter()
                .map(|(_, level)| {
                    let mut lanes = drawn.clone();
                    lanes.run_at(level, LANES);
                    (0..LANES).map(|lane| ends(&lanes, lane)).collect::<Vec<_>>()
                })
                .collect();
            assert!(ended.iter().all(|other| *other == ended[0]));
            reached += ended[0].iter().filter(|(is_reached, ..)| *is_reached).count();
        }
        assert!(reached > 800, "{reached} of 1600");
    }

    #[test]
    fn no_attempt_depends_on_those_beside_it() {
        let robot = robot();
        let mut random = Stream::new(22, 0);
        for _ in 0..20 {
            let drawn = drawn(&robot, &mut random);
            let mut together = drawn.clone();
            together.run(LANES);
            for count in 1..LANES {
                let mut fewer = drawn.clone();
                fewer.run(count);
                for lane in 0..LANES {
                    let expected = if lane < count { ends(&together, lane).0 } else { false };
                    assert_eq!(fewer.is_reached(lane), expected);
                    if expected {
                        assert_eq!(ends(&fewer, lane), ends(&together, lane));
                    }
                }
            }
        }
    }
}
