use std::sync::Arc;

use cranny_grasp::{GripForces, LoadState};
use cranny_path::{Trajectory, sample_times};
use cranny_plan::PlanError;
use cranny_robot::{Robot, between, distance};
use cranny_spatial::nalgebra::Rotation3;
use cranny_spatial::{Pose, Rotation, Vector};
use cranny_task::{Carrier, FailureReason, Firmness, Problem, Segment, StatesAlong, joined, legs};
use serde::{Deserialize, Serialize};

use crate::{TaskTrajectory, Timing};

/// Firmness with which the hand holds what it carries along a whole motion: factors by which loads may grow until a pad
/// slips, computed on the safe side (limit surface of the pads: see `LoadMeasure` of `cranny-grasp`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hold {
    /// The least of all weight and inertia along the motion in its time; `None` for a motion without times.
    pub factor: Option<f64>,
    /// The least of the weight alone, at rest in each attitude of the motion.
    pub at_rest: f64,
    /// True if the mass of an object is not stated, and was assumed from its volume.
    pub mass_assumed: bool,
}

/// Samples of a motion, in Hz.
const RATE_HZ: f64 = 100.0;
/// Step of the differences that give the motion of the hand, in seconds.
const STEP_S: f64 = 1e-3;
/// Step in joint space (m, rad) at which the attitudes of a path are looked at.
const LOOK_EVERY: f64 = 0.05;
/// Speeds are multiples of this share of the limits: a legible number, and at least one.
const SPEED_STEP: f64 = 1e-3;

/// What is in the hand, and how firmly.
#[derive(Clone, Debug)]
pub(crate) struct FirmGrip {
    forces: GripForces,
    is_mass_assumed: bool,
    world_from_closed: Pose,
}

impl FirmGrip {
    /// Of the object of a carrier in the hand that closed at a configuration (m, rad; one per joint); `None` where it cannot
    /// be computed, or no pad bears.
    pub fn new(problem: &Problem, carrier: &Carrier, closed_at: &[f64]) -> Option<Self> {
        let firmness = carrier.firmness(problem)?;
        Self::of(&firmness, problem.robot(), closed_at)
    }

    /// The same of a firmness that is at hand, the hand closed at a configuration (m, rad; one per joint).
    pub fn of(firmness: &Firmness, robot: &Robot, closed_at: &[f64]) -> Option<Self> {
        let world_from_closed = *robot.frames_at(closed_at).link(robot.tip());
        let forces = firmness.grip(&world_from_closed)?;
        Some(Self { forces, is_mass_assumed: firmness.is_mass_assumed, world_from_closed })
    }

    /// The least factor of the weight along a path of way points (m, rad; one value per joint).
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

    /// The motions of the hand along a leg, every 10 ms.
    fn states(&self, robot: &Robot, leg: &Trajectory) -> Result<Vec<LoadState>, PlanError> {
        let mut frames = robot.frames();
        let to_closed = self.world_from_closed.rotation.inverse();
        let state = |time_s: f64| {
            let sample = leg.sample(time_s);
            // The joints as they go on from here, for their acceleration may jump.
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
        Ok(sample_times(leg.duration_s(), RATE_HZ)?.map(state).collect())
    }

    /// The least factor over motions that are run through at a share of their speed.
    fn factor(&self, states: &[LoadState], share: f64) -> f64 {
        let slowed = states.iter().map(|state| LoadState {
            acceleration: state.acceleration * share.powi(2),
            rate: state.rate * share,
            rate_acceleration: state.rate_acceleration * share.powi(2),
            ..*state
        });
        slowed.map(|state| self.forces.factor(&state)).fold(f64::INFINITY, f64::min)
    }

    /// The least factor along segments in their time; `None` for a robot without the limits for one.
    fn factor_of(
        &self,
        problem: &Problem,
        leg: &[Segment],
        timing: Timing,
    ) -> Result<Option<f64>, PlanError> {
        let Some(timed) = TaskTrajectory::of(timing, problem.robot(), leg)? else { return Ok(None) };
        Ok(Some(self.factor(&self.states(problem.robot(), timed.reach())?, 1.0)))
    }

    /// The greatest share of the speed at which loads may grow by a factor; `None` if they may at no speed.
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

/// Gives each segment that holds an object the greatest speed at which the hand holds it by a factor, and measures the
/// hold; `None` for a motion on which nothing is held, or where it cannot be computed for all that is.
///
/// # Errors
/// [`FailureReason::Slips`] within for a motion on which it does not at any speed.
pub(crate) fn hold_firmly(
    problem: &Problem,
    along: &StatesAlong,
    segments: &mut [Segment],
    (timing, demanded): (Timing, f64),
) -> Result<Result<Option<Hold>, FailureReason>, PlanError> {
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
        let states = grip.states(problem.robot(), leg.reach())?;
        let Some(mut share) = grip.fastest(&states, demanded) else {
            return Ok(Err(FailureReason::Slips));
        };
        // Samples of the slower motion may lie nearer to where its load is greatest.
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

impl Hold {
    /// The hold along segments in their time; `None` for a motion on which nothing is held, or where it cannot be computed
    /// for all that is.
    ///
    /// # Errors
    /// [`PlanError`] for a path that cannot be timed.
    pub fn of(
        problem: &Problem,
        along: &StatesAlong,
        segments: &[Segment],
        timing: Timing,
    ) -> Result<Option<Self>, PlanError> {
        let Some(grips) = grips(problem, along, segments) else { return Ok(None) };
        measured(problem, &grips, segments, timing)
    }
}

/// Segments, by index, and what is in the hand along them.
type Legs = Vec<(std::ops::Range<usize>, FirmGrip)>;

fn grips(problem: &Problem, along: &StatesAlong, segments: &[Segment]) -> Option<Legs> {
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
) -> Result<Option<Hold>, PlanError> {
    let mut hold: Option<Hold> = None;
    for (range, grip) in grips {
        let leg = &segments[range.clone()];
        let factor = grip.factor_of(problem, leg, timing)?;
        let at_rest = grip.at_rest(problem.robot(), &joined(leg));
        let of_leg = Hold { factor, at_rest, mass_assumed: grip.is_mass_assumed };
        hold = Some(hold.map_or(of_leg, |hold| Hold {
            factor: hold.factor.zip(of_leg.factor).map(|(a, b)| a.min(b)),
            at_rest: hold.at_rest.min(of_leg.at_rest),
            mass_assumed: hold.mass_assumed || of_leg.mass_assumed,
        }));
    }
    Ok(hold)
}
