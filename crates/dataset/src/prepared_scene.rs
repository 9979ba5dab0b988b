use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use cranny_collision::{Cell, Scratch};
use cranny_path::{AuditSettings, Clearances, ShortcutSettings, shortcut};
use cranny_plan::{Budget, GoalPool, Outcome, PlanReport, Planner, Registry, Statistics, Unobserved, search};
use cranny_scenario::{Family, Recipe};
use cranny_solve::{Answer, Request, Timing, solve_with};
use cranny_spatial::{Stream, other_seed};
use cranny_task::{
    Carrier, FailureReason, Goal, GraspFailure, IkAnnotationSettings, IkStatus, PlaceAt, Problem, Segment,
    Stage, annotate_ik, gripper_poses,
};

use crate::demonstration::Demonstration;
use crate::figures::Figures;
use crate::scene_row::SceneRow;
use crate::scene_source::{SceneSource, problem_of};
use crate::{DatasetError, DatasetRecipe, DemonstrationTask, GraspReasons};

/// Results at a grasp, in the order of their bytes in [`SceneRow::grasp_results`].
pub const GRASP_RESULTS: [&str; 9] = [
    "reachable",
    "too-wide",
    "out-of-reach",
    "hand-collides",
    "no-ik",
    "arm-collides",
    "self-collision",
    "not-tried",
    "other",
];

/// Number of `not-tried` among [`GRASP_RESULTS`].
const NOT_TRIED: u8 = 7;

/// Number of goal configurations of a scene that suffice, and of batches of inverse kinematics after which no more are sought.
const GOALS: usize = 100;
const MOST_BATCHES: usize = 40;

/// Attempts of inverse kinematics at a grasp that did not come up before, if the results at all grasps are asked for.
const ATTEMPTS: usize = 100;

/// Share of the iterations that a search without a known path gets first, when another query of the scene has found one.
const FRESH_SHARE: u64 = 8;

/// Number of earlier paths of a scene that a search may join.
const JOINED_PATHS: usize = 3;

/// Number of random starts that are drawn; the robot's own start is taken if none is free.
const MOST_STARTS: usize = 100;
/// Greatest distance of a joint of a random start from the robot's own, for a spread of 1 (m, rad).
const FARTHEST_START: f64 = std::f64::consts::PI;
/// … and that of a base that drives, in metres.
const FARTHEST_BASE_M: f64 = 2.0;

/// Streams of random numbers of the rows, apart from those of the scenes.
const STREAM_OF_ROWS: u64 = 1;

/// A scene with everything that its queries share: cell, goal configurations, the carrier of the object, and the paths that
/// earlier queries found.
pub(crate) struct PreparedScene<'a> {
    source: &'a SceneSource,
    of: &'a DatasetRecipe,
    row: SceneRow,
    problem: Problem,
    cell: Arc<Cell>,
    scratch: Scratch,
    goals: Vec<Vec<f64>>,
    carrier: Option<Arc<Carrier>>,
    paths: Vec<Vec<Vec<f64>>>,
}

impl<'a> PreparedScene<'a> {
    /// Prepares the scene of a row.
    pub fn new(source: &'a SceneSource, row: SceneRow, recipe: &Recipe) -> Result<Self, DatasetError> {
        let of = source.recipe();
        let problem = problem_of(recipe, of.margins())?;
        let cell = problem.exact_cell("dataset")?.clone();
        let mut scene = Self {
            source,
            of,
            row,
            scratch: cell.scratch(),
            problem,
            cell,
            goals: Vec::new(),
            carrier: None,
            paths: Vec::new(),
        };
        scene.find_goals();
        if scene.of.reasons == GraspReasons::All {
            scene.try_all_grasps()?;
        }
        Ok(scene)
    }

    /// Row of the scene.
    pub fn into_row(self) -> SceneRow {
        self.row
    }

    /// Finds goal configurations by batches of inverse kinematics, and the result at each grasp.
    fn find_goals(&mut self) {
        let Some(grasps) = self.problem.grasps().cloned() else { return };
        let mut pool = GoalPool::new(&self.problem, &self.cell, &grasps);
        let mut random = Stream::new(other_seed(self.of.seed, STREAM_OF_ROWS + 1), self.row.scene);
        let mut statistics = Statistics::default();
        for _ in 0..MOST_BATCHES {
            if pool.is_hopeless() || self.goals.len() >= GOALS {
                break;
            }
            let found = pool.draw_batch(&[], &mut random, &mut self.scratch, &mut statistics);
            self.goals.extend(found.into_iter().map(|(_, q)| q));
        }
        let failures = pool.failures(&mut self.scratch);
        drop(pool);
        for GraspFailure { grasp, reason, .. } in failures {
            let mut result = result_of(&reason);
            if reason == FailureReason::NotTried {
                let poses = gripper_poses(&grasps.grasps()[grasp]);
                let is_blocked =
                    poses.iter().all(|pose| self.cell.hand_contact(pose, &mut self.scratch).is_some());
                result = if is_blocked { 3 } else { result };
            }
            self.row.grasp_results[grasp] = result;
        }
        self.row.goals = self.goals.len() as u64;
    }

    /// Determines the result at each grasp that did not come up among the goals.
    fn try_all_grasps(&mut self) -> Result<(), DatasetError> {
        let seed = other_seed(other_seed(self.of.seed, STREAM_OF_ROWS + 3), self.row.scene);
        let settings = IkAnnotationSettings { attempts: ATTEMPTS, seed, ..IkAnnotationSettings::default() };
        if self.row.grasp_results.is_empty() {
            return Ok(());
        }
        let bodies: Vec<&str> = self.cell.world().bodies().iter().map(|body| &body.name[..]).collect();
        for found in annotate_ik(&self.problem, &settings, &|| (), &AtomicBool::new(false))? {
            let Some(result) = self.row.grasp_results.get_mut(found.grasp) else { continue };
            if *result == NOT_TRIED {
                *result = result_of_status(&found.status, &bodies);
            }
        }
        Ok(())
    }

    /// Answers the query of a row.
    pub fn answer(&mut self, row: u64) -> Result<Demonstration, DatasetError> {
        let (task, seed, mut random) = asked(self.of, row);
        let is_first = row.is_multiple_of(self.of.queries_per_scene);
        let start = if is_first { self.problem.start().to_vec() } else { self.drawn_start(&mut random) };
        let problem = self.problem.with_start(&start)?;
        let mut demonstration = Demonstration {
            row,
            scene: self.row.scene,
            task: task.name().to_owned(),
            seed,
            start,
            ..Demonstration::empty()
        };
        let stages = stages_of(task);
        let (outcome, segments, hold, reason) = if task == DemonstrationTask::Reach {
            let (outcome, path) = self.reach(&problem, seed)?;
            let segments = if path.is_empty() { Vec::new() } else { vec![Segment::reach(path, Vec::new())] };
            (outcome, segments, None, String::new())
        } else {
            let answer = self.carry(&problem, stages.clone(), seed)?;
            let reason = GraspFailure::commonest(&answer.failures).map(reason_name).unwrap_or_default();
            let is_solved = answer.is_solved();
            let outcome = if !is_solved && answer.outcome == Outcome::Solved {
                Outcome::GaveUp
            } else {
                answer.outcome
            };
            let segments = if is_solved { answer.segments } else { Vec::new() };
            (outcome, segments, answer.hold, reason)
        };
        outcome.name().clone_into(&mut demonstration.outcome);
        demonstration.reason = reason;
        if segments.is_empty() {
            return Ok(demonstration);
        }
        let figures = Figures::of(&problem, &stages, &segments, self.carrier.as_ref(), &mut self.scratch)?;
        let Some(figures) = figures.filter(|figures| figures.is_valid) else {
            Outcome::ClaimedNotProven.name().clone_into(&mut demonstration.outcome);
            return Ok(demonstration);
        };
        demonstration.set_segments(&segments);
        figures.write(&mut demonstration);
        if let Some(factor) = hold.map(|hold| hold.factor.unwrap_or(hold.at_rest)) {
            demonstration.hold_checked = true;
            demonstration.hold_factor = factor;
        }
        Ok(demonstration)
    }

    /// Returns a free random configuration about the robot's own start.
    fn drawn_start(&mut self, random: &mut Stream) -> Vec<f64> {
        let robot = self.cell.robot().clone();
        let own = self.problem.start();
        for _ in 0..MOST_STARTS {
            let joints = own.iter().zip(robot.limits()).zip(robot.joints());
            let q: Vec<f64> = joints
                .map(|((own, limits), joint)| {
                    let is_linear = joint.kind == cranny_robot::JointKind::Prismatic;
                    let most = if is_linear { FARTHEST_BASE_M } else { FARTHEST_START };
                    let (lower, upper) = (limits.lower.max(own - most), limits.upper.min(own + most));
                    own + self.of.start_spread * (random.uniform_between(lower, upper) - own)
                })
                .collect();
            if self.cell.is_free(&q, &mut self.scratch) {
                return q;
            }
        }
        own.to_vec()
    }

    /// Searches for a path to a grasp.
    ///
    /// 1. The planner `reach` searches for a path to any goal configuration of the scene; another planner gets the grasps.
    /// 2. If an earlier query of the scene has a path, the first search is short; a second one may join the earlier paths at any
    ///    of their way points.
    fn reach(&mut self, problem: &Problem, seed: u64) -> Result<(Outcome, Vec<Vec<f64>>), DatasetError> {
        let planner = Registry::default().planner_with(&self.of.planner, &self.of.settings)?;
        let is_shared = planner.name() == "reach";
        if is_shared && self.goals.is_empty() {
            return Ok((Outcome::GaveUp, Vec::new()));
        }
        let goal_problem = if is_shared {
            problem.with_goal(Goal::Configurations(self.goals.clone()))?
        } else {
            problem.clone()
        };
        // 1.
        let may_join = is_shared && !self.paths.is_empty();
        let iterations =
            if may_join { (self.of.iterations / FRESH_SHARE).max(1) } else { self.of.iterations };
        let PlanReport { mut outcome, mut path, .. } =
            searched(planner.as_ref(), &goal_problem, iterations, seed)?;
        // 2.
        if outcome == Outcome::BudgetExhausted && may_join {
            let known: Vec<Vec<f64>> = self.paths.iter().flatten().cloned().collect();
            let joining = problem.with_goal(Goal::Configurations([self.goals.clone(), known].concat()))?;
            let report = searched(planner.as_ref(), &joining, self.of.iterations, seed)?;
            (outcome, path) = (report.outcome, report.path);
            let earlier = |way: &&Vec<Vec<f64>>| path.last().is_some_and(|last| way.contains(last));
            if let Some(way) = self.paths.iter().find(earlier) {
                let at = way.iter().position(|q| path.last() == Some(q)).unwrap_or(way.len());
                let rest = way.get(at + 1..).unwrap_or_default().to_vec();
                path.extend(rest);
            }
        }
        if path.is_empty() {
            return Ok((outcome, path));
        }
        if self.of.changes > 0 {
            let settings = ShortcutSettings { attempts: self.of.changes, seed };
            path = shortcut(&goal_problem, &path, settings)?.path;
        }
        if is_shared && self.paths.len() < JOINED_PATHS {
            self.paths.push(path.clone());
        }
        Ok((outcome, path))
    }

    /// Searches for a path through several stages.
    fn carry(&mut self, problem: &Problem, stages: Vec<Stage>, seed: u64) -> Result<Answer, DatasetError> {
        if self.carrier.is_none() {
            self.carrier = self.source.carrier(self.row.scene, problem)?;
        }
        let request = Request {
            planner: Some(self.of.planner.clone()),
            settings: self.of.settings.clone(),
            budget: budget(self.of.iterations),
            seed,
            keep_path: self.of.changes == 0,
            changes: Some(self.of.changes),
            stages,
            timing: Some(Timing { stops: true, ..Timing::default() }),
            audit: AuditSettings { clearances: Clearances::None, ..AuditSettings::default() },
            hold: self.of.hold,
            ..Request::default()
        };
        Ok(solve_with(problem, &request, self.carrier.as_ref(), &mut Unobserved)?)
    }
}

/// Returns the stages of a task; those of a reach are the goal of the problem alone.
pub(crate) fn stages_of(task: DemonstrationTask) -> Vec<Stage> {
    match task {
        DemonstrationTask::Reach => vec![Stage::pick()],
        DemonstrationTask::Carry => vec![Stage::pick(), Stage::home()],
        DemonstrationTask::Place => vec![Stage::pick(), Stage::Place(PlaceAt::named(Family::OUTSIDE))],
    }
}

fn budget(iterations: u64) -> Budget {
    // A limit of time would make the result depend on the machine.
    Budget { iterations, time: Duration::MAX }
}

fn searched(
    planner: &dyn Planner,
    problem: &Problem,
    iterations: u64,
    seed: u64,
) -> Result<PlanReport, DatasetError> {
    Ok(search(planner, problem, &budget(iterations), seed, &mut Unobserved)?)
}

/// Returns the task of a row, the seed of its search, and the stream of its other random numbers.
pub(crate) fn asked(recipe: &DatasetRecipe, row: u64) -> (DemonstrationTask, u64, Stream) {
    let mut random = Stream::new(other_seed(recipe.seed, STREAM_OF_ROWS), row);
    let task = drawn_task(recipe, &mut random);
    (task, other_seed(other_seed(recipe.seed, STREAM_OF_ROWS + 2), row), random)
}

fn drawn_task(recipe: &DatasetRecipe, random: &mut Stream) -> DemonstrationTask {
    let total: f64 = recipe.tasks.values().fold(0.0, |sum, weight| sum + weight);
    let mut left = random.uniform() * total;
    let mut last = DemonstrationTask::Reach;
    for (task, weight) in recipe.tasks.iter().filter(|(_, weight)| **weight > 0.0) {
        last = *task;
        left -= weight;
        if left < 0.0 {
            break;
        }
    }
    last
}

/// Returns the number of a status among [`GRASP_RESULTS`].
fn result_of_status(status: &IkStatus, bodies: &[&str]) -> u8 {
    match status {
        IkStatus::Solved => 0,
        IkStatus::OutOfReach { .. } => 2,
        IkStatus::HandCollides { .. } => 3,
        IkStatus::NoSolution { blocked: 0, .. } => 4,
        IkStatus::NoSolution { contact: Some((_, body)), .. } if bodies.contains(&&body[..]) => 5,
        IkStatus::NoSolution { contact: Some(_), .. } => 6,
        IkStatus::NoSolution { .. } => 8,
        IkStatus::Stopped => NOT_TRIED,
    }
}

fn result_of(reason: &FailureReason) -> u8 {
    match reason {
        FailureReason::NotConnected { .. } => 0,
        FailureReason::TooWide { .. } => 1,
        FailureReason::OutOfReach { .. } => 2,
        FailureReason::HandCollides { .. } => 3,
        FailureReason::NoIk => 4,
        FailureReason::ArmCollides { .. } => 5,
        FailureReason::SelfCollision { .. } => 6,
        FailureReason::NotTried => NOT_TRIED,
        _ => 8,
    }
}

/// Returns the name of a reason in plan files.
fn reason_name(reason: &FailureReason) -> String {
    let innermost = |reason: &FailureReason| match reason {
        FailureReason::Later { because, .. } => FailureReason::clone(because),
        other => other.clone(),
    };
    let value = serde_json::to_value(innermost(reason)).unwrap_or_default();
    value.get("reason").and_then(|name| name.as_str()).unwrap_or_default().to_owned()
}
