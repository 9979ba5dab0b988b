use cranny_grasp::{Grasp, GraspSet, SamplerSettings, TooWide};
use cranny_path::{BaseEnclosure, base_enclosure};
use cranny_robot::{IkSettings, IkSolution, IkSolver, Robot};
use cranny_spatial::{EXACT_TRANSLATION_M, Point, Pose, Stream, Vector};
use cranny_task::{FailureReason, GraspFailure, GraspMeasure, Problem};
use serde::{Deserialize, Serialize};

use crate::search::base_shift::base_shift_m;
use crate::search::grasp_source::GraspSource;

/// Reason why no grasp of a search was feasible.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "reason")]
#[non_exhaustive]
pub enum NoGrasp {
    /// The target is wider than the hand opens at every sample, and no grasps are given.
    TooWide(TooWide),
    /// The arm reaches none of the grasps.
    OutOfReach(ReachMiss),
    /// The base cannot leave a region from which no goal is in reach, which is proven.
    BaseEnclosed(BaseEnclosure),
}

/// Nearest approach of an arm to the grasps that it does not reach.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReachMiss {
    /// Index of the nearest grasp; `None` for a sampled one, if none are given.
    pub grasp: Option<usize>,
    /// Lower bound of the distance of that grasp from everything within reach, in metres; 0 if the bound does not exclude it.
    pub beyond_m: f64,
    /// Distance of the tip from that grasp at the end of the best attempt of inverse kinematics, in metres.
    pub missed_by_m: f64,
    /// Rotation of the tip relative to that grasp there, in radians.
    pub turned_by_rad: f64,
    /// Names of the joints at a limit there.
    pub joints_at_limits: Vec<String>,
    /// Displacement of the base, along x and y of the planning frame in metres, that gives a free configuration at a grasp;
    /// `None` if no tried displacement does.
    pub base_shift_m: Option<[f64; 2]>,
}

/// Returns the reason for each excluded grasp of a problem if all are excluded before any search: by their stated widths, or
/// provably beyond reach. The list is empty if grasps would be sampled, but none can be.
pub(crate) fn all_excluded(problem: &Problem) -> Option<Vec<GraspFailure>> {
    let cell = problem.cell()?;
    let robot = cell.robot();
    if let Some(measure) = problem.grasp_measure() {
        let is_excluded =
            own_beyond_m(robot, measure) > 0.0 || GraspSource::too_wide(measure, cell.margins()).is_some();
        return is_excluded.then(Vec::new);
    }
    let grasps = problem.grasps().filter(|grasps| !grasps.is_empty())?.grasps();
    // In most problems an early grasp is not excluded, which ends the iteration.
    let reach = robot.reach_bound();
    let failure = |(grasp, given): (usize, &Grasp)| {
        let at = Point::from(given.world_from_gripper.translation.vector);
        let beyond_m = reach.beyond_m(&at) - EXACT_TRANSLATION_M;
        let out_of_reach = (beyond_m > 0.0).then_some(FailureReason::OutOfReach { beyond_m });
        let reason = FailureReason::of_width(robot, given).or(out_of_reach)?;
        Some(GraspFailure { grasp, reason, attempts: 0 })
    };
    grasps.iter().enumerate().map(failure).collect()
}

/// Returns a lower bound of the distance of any grasp of the target from everything within reach, in metres. The gripper frame
/// lies no farther from the target surface than the hand opens.
fn own_beyond_m(robot: &Robot, measure: &GraspMeasure) -> f64 {
    let surface = measure.surface_in_world().aabb();
    robot.reach_bound().beyond_m(&surface.center) - surface.half_extents.norm() - measure.opening_m()
}

impl NoGrasp {
    /// Determines the reason after a search without a path, given the failures of its grasps, in some milliseconds. `None` if
    /// the arm reached a grasp, or may have, unless the base is enclosed.
    pub fn of(problem: &Problem, failures: &[GraspFailure]) -> Option<Self> {
        if let Some(enclosure) = base_enclosure(problem) {
            return Some(Self::BaseEnclosed(enclosure));
        }
        let cell = problem.cell()?;
        let robot = cell.robot();
        let candidates: Vec<(Option<usize>, Grasp)> = if let Some(measure) = problem.grasp_measure() {
            if let Some(too_wide) = GraspSource::too_wide(measure, cell.margins()) {
                return Some(Self::TooWide(too_wide));
            }
            let is_out_of_reach = own_beyond_m(robot, measure) > 0.0;
            let sampled = if is_out_of_reach { sampled(measure) } else { Vec::new() };
            sampled.into_iter().map(|grasp| (None, grasp)).collect()
        } else {
            let is_missed = |failure: &&GraspFailure| {
                matches!(failure.reason, FailureReason::NoIk | FailureReason::OutOfReach { .. })
            };
            let is_told = |failure: &GraspFailure| {
                is_missed(&failure)
                    || matches!(
                        failure.reason,
                        FailureReason::HandCollides { .. }
                            | FailureReason::TooWide { .. }
                            | FailureReason::NotTried
                    )
            };
            if !failures.iter().all(is_told) {
                return None;
            }
            let given = problem.grasps()?.grasps();
            let missed = failures
                .iter()
                .filter(is_missed)
                .filter_map(|failure| Some((Some(failure.grasp), *given.get(failure.grasp)?)));
            missed.collect()
        };
        ReachMiss::of(problem, robot, candidates).map(Self::OutOfReach)
    }
}

fn sampled(measure: &GraspMeasure) -> Vec<Grasp> {
    const COUNT: usize = 8;
    const DRAWS: usize = 1000;
    let Ok(sampler) = GraspSource::sampler(measure) else { return Vec::new() };
    let mut random = Stream::new(SamplerSettings::default().seed, 0);
    let mut grasps = Vec::new();
    for _ in 0..DRAWS {
        sampler.draw(&mut random, &mut |sampled| grasps.push(sampled.grasp));
        if grasps.len() >= COUNT {
            break;
        }
    }
    grasps
}

/// End of an attempt of inverse kinematics at a grasp.
struct Attempt {
    grasp: Option<usize>,
    goal: Grasp,
    beyond_m: f64,
    q: Vec<f64>,
    missed_by_m: f64,
    turned_by_rad: f64,
}

/// Repeats an attempt from its end as long as it comes closer, because an attempt at a distant pose ends early.
fn end_near(solver: &mut IkSolver, pose: &Pose, begin: &[f64]) -> (IkSolution, bool) {
    const ROUNDS: usize = 50;
    /// Minimum progress of an attempt for another one, in metres.
    const NEARER_M: f64 = 1e-3;
    let (mut end, mut is_reached) = solver.approach(pose, begin);
    for _ in 0..ROUNDS {
        let (next, is_there) = solver.approach(pose, &end.q);
        if is_reached || next.translation_error_m > end.translation_error_m - NEARER_M {
            break;
        }
        (end, is_reached) = (next, is_there);
    }
    (end, is_reached)
}

impl ReachMiss {
    /// Finds the attempt of inverse kinematics that ends nearest to a candidate.
    ///
    /// 1. Tries the nearest grasps by the bound of [`Robot::reach_bound`], from the start and from random configurations.
    /// 2. Reports the attempt that ends nearest; a grasp that is reached after all is no miss.
    /// 3. Shifts the base towards it.
    fn of(problem: &Problem, robot: &Robot, candidates: Vec<(Option<usize>, Grasp)>) -> Option<Self> {
        /// Number of grasps to try.
        const GRASPS: usize = 8;
        /// Number of random configurations at which attempts begin, per grasp.
        const STARTS: u64 = 3;
        let reach = robot.reach_bound();
        let beyond_m = |grasp: &Grasp| {
            let at = Point::from(grasp.world_from_gripper.translation.vector);
            (reach.beyond_m(&at) - EXACT_TRANSLATION_M).max(0.0)
        };
        // 1.
        let mut nearest: Vec<_> =
            candidates.into_iter().map(|(grasp, goal)| (grasp, goal, beyond_m(&goal))).collect();
        nearest.sort_by(|a, b| a.2.total_cmp(&b.2));
        nearest.truncate(GRASPS);
        let mut solver = IkSolver::new(robot, IkSettings { max_iterations: 100, ..IkSettings::default() });
        let mut random = Stream::new(0, 0);
        let mut best: Option<Attempt> = None;
        for (grasp, goal, beyond_m) in &nearest {
            for pose in [goal.world_from_gripper, goal.twin().world_from_gripper] {
                for start in 0..=STARTS {
                    let drawn = robot
                        .limits()
                        .iter()
                        .map(|limits| random.uniform_between(limits.lower, limits.upper));
                    let begin = if start == 0 { problem.start().to_vec() } else { drawn.collect() };
                    let (end, is_reached) = end_near(&mut solver, &pose, &begin);
                    // 2.
                    if is_reached {
                        return None;
                    }
                    if best.as_ref().is_none_or(|best| end.translation_error_m < best.missed_by_m) {
                        best = Some(Attempt {
                            grasp: *grasp,
                            goal: *goal,
                            beyond_m: *beyond_m,
                            q: end.q,
                            missed_by_m: end.translation_error_m,
                            turned_by_rad: end.rotation_error_rad,
                        });
                    }
                }
            }
        }
        let Attempt { grasp, goal, beyond_m, q, missed_by_m, turned_by_rad } = best?;
        let names = robot.joint_names().iter().zip(robot.limits()).zip(&q);
        let at_limits =
            names.filter(|((_, limits), value)| **value <= limits.lower || **value >= limits.upper);
        let joints_at_limits = at_limits.map(|((name, _), _)| name.clone()).collect();
        // 3.
        let tip = robot.frames_at(&q).link(robot.tip()).translation.vector;
        let way: Vector = goal.world_from_gripper.translation.vector - tip;
        let goals = GraspSet::new(nearest.into_iter().map(|(_, goal, _)| goal).collect()).ok()?;
        let base_shift_m = base_shift_m(problem, &goals, &way);
        Some(Self { grasp, beyond_m, missed_by_m, turned_by_rad, joints_at_limits, base_shift_m })
    }
}
