use std::sync::Arc;

use cranny_grasp::{GripForces, LoadState};
use cranny_path::Trajectory;
use cranny_plan::PlanError;
use cranny_robot::{Robot, between, distance};
use cranny_spatial::nalgebra::Rotation3;
use cranny_spatial::{Pose, Rotation, Vector};
use cranny_task::{Carrier, FailureReason, LoadModel, Problem, Segment, StateSequence, joined, legs};
use serde::{Deserialize, Serialize};

use crate::{TaskTrajectory, Timing};

/// Firmness of the hold on the carried object along a whole motion: factors by which loads may grow until a pad slips, as
/// lower bounds by the limit surface of the pads (see `LoadMeasure` of `cranny-grasp`), but for some thousandths between the instants
/// that are examined.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoldFactors {
    /// Least factor for weight and inertia along the timed motion; `None` for a motion without times.
    pub factor: Option<f64>,
    /// Least factor for the weight alone, at rest in each orientation of the motion.
    pub at_rest: f64,
    /// True if the mass of an object is not stated, and was assumed from its volume.
    pub mass_assumed: bool,
}

/// Greatest length of the parts into which smooth motion is divided, and that of the parts of a short one, in seconds.
const PART_S: [f64; 2] = [0.01, 0.002];
/// Number of parts up to which a smooth motion is short.
const SHORT: f64 = 4.0;
/// Step of the finite differences for the motion of the hand, in seconds.
const STEP_S: f64 = 1e-3;
/// Sampling distance in joint space (m, rad) of the orientations along a path.
const LOOK_EVERY: f64 = 0.02;
/// Increment and least value of the share of the speed limits; its multiples have few digits.
const SPEED_STEP: f64 = 1e-3;

/// The object in the hand and the forces of the grip.
#[derive(Clone, Debug)]
pub(crate) struct FirmGrip {
    forces: GripForces,
    is_mass_assumed: bool,
    world_from_closed: Pose,
}

impl FirmGrip {
    /// Creates the grip on the object of a carrier in the hand that closed at a configuration (m, rad; one per joint); `None`
    /// if it cannot be computed, or no pad bears load.
    pub fn new(problem: &Problem, carrier: &Carrier, closed_at: &[f64]) -> Option<Self> {
        let load_model = carrier.load_model(problem)?;
        Self::of(&load_model, problem.robot(), closed_at)
    }

    /// Creates the grip from a known load model, the hand closed at a configuration (m, rad; one per joint).
    pub fn of(load_model: &LoadModel, robot: &Robot, closed_at: &[f64]) -> Option<Self> {
        let world_from_closed = *robot.frames_at(closed_at).link(robot.tip());
        let forces = load_model.grip(&world_from_closed)?;
        Some(Self { forces, is_mass_assumed: load_model.is_mass_assumed, world_from_closed })
    }

    /// Returns the least factor for the weight alone along a path of way points (m, rad; one value per joint).
    pub fn at_rest(&self, robot: &Robot, path: &[Vec<f64>]) -> f64 {
        let mut frames = robot.frames();
        let mut least = f64::INFINITY;
        let mut look = |q: &[f64]| {
            robot.tip_kinematics(q, &mut frames);
            let turn = self.turn_to(&frames.link(robot.tip()).rotation);
            least = least.min(self.forces.factor(&LoadState { turn, ..LoadState::GRAVITY }));
        };
        if let Some(first) = path.first() {
            look(first);
        }
        for edge in path.windows(2) {
            let pieces = (distance(&edge[0], &edge[1]) / LOOK_EVERY).ceil().clamp(1.0, 1e5);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
            for piece in 1..=pieces as u32 {
                let share = (f64::from(piece) / pieces).min(1.0);
                look(&between(&edge[0], &edge[1], share).collect::<Vec<f64>>());
            }
        }
        least
    }

    fn turn_to(&self, world_from_tip: &Rotation) -> Rotation3<f64> {
        (self.world_from_closed.rotation.inverse() * world_from_tip).to_rotation_matrix()
    }

    /// Returns states of the hand along a leg, whose convex hull contains all others, but for third differences of its accelerations
    /// over some milliseconds: the loads that a factor allows are a convex set, so none of them has a lower factor.
    ///
    /// The motion is smooth between its switches. Each part of it has a state at both ends, and the middle one of the three control
    /// points of the parabola through these and the state halfway.
    fn states(&self, robot: &Robot, leg: &Trajectory) -> Vec<LoadState> {
        let mut frames = robot.frames();
        let to_closed = self.world_from_closed.rotation.inverse();
        let mut state = |time_s: f64| {
            let sample = leg.sample(time_s);
            // Extrapolate the joints from this sample, because their acceleration may jump.
            let mut tip = |after_s: f64| {
                let joints = sample.position.iter().zip(&sample.velocity).zip(&sample.acceleration);
                let q: Vec<f64> = joints.map(|((q, v), a)| q + after_s * (v + 0.5 * after_s * a)).collect();
                robot.tip_kinematics(&q, &mut frames);
                *frames.link(robot.tip())
            };
            let [before, now, after] = [-STEP_S, 0.0, STEP_S].map(&mut tip);
            let place = |pose: &Pose| pose.translation.vector;
            let acceleration: Vector =
                (place(&after) - 2.0 * place(&now) + place(&before)) / (STEP_S * STEP_S);
            let turned = |pose: &Pose| (now.rotation.inverse() * pose.rotation).scaled_axis();
            LoadState {
                lift: 0.0,
                acceleration: to_closed * acceleration,
                rate: (turned(&after) - turned(&before)) / (2.0 * STEP_S),
                rate_acceleration: (turned(&after) + turned(&before)) / (STEP_S * STEP_S),
                turn: self.turn_to(&now.rotation),
            }
        };
        let mut states = Vec::new();
        for span in leg.switches_s().windows(2) {
            let length_s = span[1] - span[0];
            let parts = (length_s / PART_S[1]).ceil().min(SHORT).max((length_s / PART_S[0]).ceil());
            // Just within the span, on whose ends an acceleration may jump.
            let mut at = |part: f64| state(span[0] + length_s * (1e-6 + (1.0 - 2e-6) * part / parts));
            let (mut begin, mut part) = (at(0.0), 0.0);
            while part < parts {
                let (middle, end) = (at(part + 0.5), at(part + 1.0));
                let control =
                    |of: fn(&LoadState) -> Vector| 2.0 * of(&middle) - 0.5 * (of(&begin) + of(&end));
                let control = LoadState {
                    acceleration: control(|state| state.acceleration),
                    rate: control(|state| state.rate),
                    rate_acceleration: control(|state| state.rate_acceleration),
                    ..middle
                };
                states.extend([begin, control]);
                (begin, part) = (end, part + 1.0);
            }
            states.push(begin);
        }
        states
    }

    /// Returns the least factor over load states, with the motion slowed down to a share of its speed.
    fn factor(&self, states: &[LoadState], share: f64) -> f64 {
        let slowed = states.iter().map(|state| LoadState {
            acceleration: state.acceleration * share.powi(2),
            rate: state.rate * share,
            rate_acceleration: state.rate_acceleration * share.powi(2),
            ..*state
        });
        slowed.map(|state| self.forces.factor(&state)).fold(f64::INFINITY, f64::min)
    }

    /// Returns the least factor along timed segments; `None` for a robot without the required limits.
    fn factor_of(
        &self,
        problem: &Problem,
        leg: &[Segment],
        timing: Timing,
    ) -> Result<Option<f64>, PlanError> {
        let Some(timed) = TaskTrajectory::of(timing, problem.robot(), leg)? else { return Ok(None) };
        Ok(Some(self.factor(&self.states(problem.robot(), timed.reach()), 1.0)))
    }

    /// Returns the greatest share of the speed at which the factor reaches `demanded`; `None` if no speed suffices.
    fn fastest(&self, states: &[LoadState], demanded: f64) -> Option<f64> {
        if self.factor(states, 1.0) >= demanded {
            return Some(1.0);
        }
        let holds = |steps: u32| self.factor(states, f64::from(steps) * SPEED_STEP) >= demanded;
        let (mut low, mut high) = (0, 1000);
        while high - low > 1 {
            let middle = u32::midpoint(low, high);
            if holds(middle) { low = middle } else { high = middle }
        }
        (low > 0).then(|| f64::from(low) * SPEED_STEP)
    }
}

/// Sets for each segment with a held object the greatest speed at which the hold has the required factor, and measures the
/// factors; `None` without a held object, or if they cannot be computed for each one.
///
/// # Errors
/// [`FailureReason::Slips`] in the inner result for a motion that reaches the factor at no speed.
pub(crate) fn hold_firmly(
    problem: &Problem,
    along: &StateSequence,
    segments: &mut [Segment],
    (timing, demanded): (Timing, f64),
) -> Result<Result<Option<HoldFactors>, FailureReason>, PlanError> {
    let Some(grips) = grips(problem, along, segments) else { return Ok(Ok(None)) };
    for (range, grip) in &grips {
        let path = joined(&segments[range.clone()]);
        if demanded <= 0.0 {
            continue;
        }
        if grip.at_rest(problem.robot(), &path) < demanded {
            return Ok(Err(FailureReason::Slips));
        }
        let Some(leg) = TaskTrajectory::of(timing, problem.robot(), &segments[range.clone()])? else {
            continue;
        };
        let states = grip.states(problem.robot(), leg.reach());
        let Some(mut share) = grip.fastest(&states, demanded) else {
            return Ok(Err(FailureReason::Slips));
        };
        // The slower motion switches elsewhere.
        loop {
            for segment in &mut segments[range.clone()] {
                segment.speed = (share < 1.0).then_some(share);
            }
            let found = grip.factor_of(problem, &segments[range.clone()], timing)?;
            if found.is_none_or(|factor| factor >= demanded) {
                break;
            }
            share -= SPEED_STEP;
            if share <= 0.0 {
                return Ok(Err(FailureReason::Slips));
            }
        }
    }
    measured(problem, &grips, segments, timing).map(Ok)
}

impl HoldFactors {
    /// Measures the factors along timed segments; `None` without a held object, or if it cannot be computed for each one.
    ///
    /// # Errors
    /// [`PlanError`] for a path that cannot be timed.
    pub fn of(
        problem: &Problem,
        along: &StateSequence,
        segments: &[Segment],
        timing: Timing,
    ) -> Result<Option<Self>, PlanError> {
        let Some(grips) = grips(problem, along, segments) else { return Ok(None) };
        measured(problem, &grips, segments, timing)
    }
}

/// Ranges of segments with an object in the hand, each with its grip.
type Legs = Vec<(std::ops::Range<usize>, FirmGrip)>;

fn grips(problem: &Problem, along: &StateSequence, segments: &[Segment]) -> Option<Legs> {
    let mut begin = 0;
    let mut grips = Legs::new();
    for leg in legs(segments) {
        let range = begin..begin + leg.len();
        begin = range.end;
        if leg[0].mode.holds {
            let (carrier, _): (&Arc<Carrier>, _) = along.states.get(range.start)?.held()?;
            grips.push((range, FirmGrip::new(problem, carrier, leg[0].waypoints.first()?)?));
        }
    }
    Some(grips)
}

fn measured(
    problem: &Problem,
    grips: &Legs,
    segments: &[Segment],
    timing: Timing,
) -> Result<Option<HoldFactors>, PlanError> {
    let mut hold: Option<HoldFactors> = None;
    for (range, grip) in grips {
        let leg = &segments[range.clone()];
        let at_rest = grip.at_rest(problem.robot(), &joined(leg));
        // A rounded corner avoids the attitude of its way point, at which the motion may nevertheless be stopped.
        let factor = grip.factor_of(problem, leg, timing)?.map(|factor| factor.min(at_rest));
        let of_leg = HoldFactors { factor, at_rest, mass_assumed: grip.is_mass_assumed };
        hold = Some(hold.map_or(of_leg, |hold| HoldFactors {
            factor: hold.factor.zip(of_leg.factor).map(|(a, b)| a.min(b)),
            at_rest: hold.at_rest.min(of_leg.at_rest),
            mass_assumed: hold.mass_assumed || of_leg.mass_assumed,
        }));
    }
    Ok(hold)
}
