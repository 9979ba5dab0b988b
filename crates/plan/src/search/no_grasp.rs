use cranny_grasp::{Grasp, GraspSet, SamplerSettings, TooWide};
use cranny_robot::{IkSettings, IkSolution, IkSolver, Robot};
use cranny_spatial::{EXACT_TRANSLATION_M, Point, Pose, Stream, Vector};
use cranny_task::{FailureReason, GraspFailure, GraspMeasure, Problem};
use serde::{Deserialize, Serialize};

use crate::search::base_shift::base_shift_m;
use crate::search::grasp_source::GraspSource;

/// Reason why a search took no grasp at all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "reason")]
#[non_exhaustive]
pub enum NoGrasp {
    /// The target is wider than the hand opens wherever it was sampled, and no grasps are given.
    TooWide(TooWide),
    /// The arm comes to none of the grasps.
    OutOfReach(ReachMiss),
}

/// Nearest approach of an arm to the grasps that it does not reach.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReachMiss {
    /// The nearest grasp; `None` for one that was sampled, because none are given.
    pub grasp: Option<usize>,
    /// Least distance of that grasp from everything within reach, in metres, by a bound that holds for certain; 0 where
    /// the bound does not exclude it.
    pub beyond_m: f64,
    /// Distance of the tip from that grasp at the end of the best attempt of inverse kinematics, in metres.
    pub missed_by_m: f64,
    /// Rotation of the tip from that grasp there, in radians.
    pub turned_by_rad: f64,
    /// The joints that stand at a limit there.
    pub joints_at_limits: Vec<String>,
    /// Displacement of the base, along x and y of the planning frame in metres, with which a free configuration at a grasp
    /// was found; `None` where none of those that were tried leads to one.
    pub base_shift_m: Option<[f64; 2]>,
}

/// Why each grasp of a problem is excluded before any search, if all of them are: by their stated widths, or for certain
/// beyond reach. Empty where grasps are sampled, and none can be.
pub(crate) fn all_excluded(problem: &Problem) -> Option<Vec<GraspFailure>> {
    let cell = problem.cell()?;
    let robot = cell.robot();
    if let Some(measure) = problem.grasp_measure() {
        let is_excluded =
            own_beyond_m(robot, measure) > 0.0 || GraspSource::too_wide(measure, cell.margins()).is_some();
        return is_excluded.then(Vec::new);
    }
    let grasps = problem.grasps().filter(|grasps| !grasps.is_empty())?.grasps();
    // Most problems have a grasp that is not excluded, often the first.
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

/// Least distance of any grasp of the target from everything within reach, in metres: the gripper frame lies no farther
/// from its surface than the hand opens.
fn own_beyond_m(robot: &Robot, measure: &GraspMeasure) -> f64 {
    let surface = measure.surface_in_world().aabb();
    robot.reach_bound().beyond_m(&surface.center) - surface.half_extents.norm() - measure.opening_m()
}

impl NoGrasp {
    /// Looks for the reason after a search without a path, in which grasps failed like this: some milliseconds. `None`
    /// where the arm came to a grasp, or may have.
    pub fn of(problem: &Problem, failures: &[GraspFailure]) -> Option<Self> {
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

/// A few grasps of the target.
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

/// The end of an attempt of inverse kinematics at a grasp.
struct Attempt {
    grasp: Option<usize>,
    goal: Grasp,
    beyond_m: f64,
    q: Vec<f64>,
    missed_by_m: f64,
    turned_by_rad: f64,
}

/// Repeats an attempt from where it ends as long as it gets nearer: to what is far away one ends early.
fn end_near(solver: &mut IkSolver, pose: &Pose, begin: &[f64]) -> (IkSolution, bool) {
    const ROUNDS: usize = 50;
    /// An attempt that gets no nearer than this is the last, in metres.
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
    /// 1. The nearest grasps by the bound of [`Robot::reach_bound`] are tried, from the start and from random
    ///    configurations.
    /// 2. The attempt that ends nearest is the one to report; a grasp that is reached after all is no miss.
    /// 3. The base is shifted towards it.
    fn of(problem: &Problem, robot: &Robot, candidates: Vec<(Option<usize>, Grasp)>) -> Option<Self> {
        /// Grasps that are tried.
        const GRASPS: usize = 8;
        /// Random configurations that an attempt begins at, for each.
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
