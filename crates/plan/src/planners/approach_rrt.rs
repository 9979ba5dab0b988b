use cranny_collision::{Cell, Scratch};
use cranny_path::RELEASED_STEP_M;
use cranny_robot::{IK_BATCH, IkBatch, IkSettings, IkSolver};
use cranny_spatial::Pose;
use cranny_task::{Goal, Problem, open_gripper_poses};
use serde::{Deserialize, Serialize};

use crate::search::bidirectional::Bidirectional;
use crate::search::connector::{Connector, Path};
use crate::search::growth::Growth;
use crate::search::pose_source::open_region_poses;
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, Observer, Outcome, PlanError, PlanReport, Planner, Ranges};

/// RRT-Connect whose goals and samples come from the sides at which the hand can retreat: after Huh, Lee & Lee 2018,
/// "Constrained sampling-based planning for grasping and manipulation" (ICRA), whole, whose text was not available. Only the idea
/// that free space at the object determines the side of approach is theirs.
///
/// 1. The free retreat of a grasp is the distance by which the hand alone can move back along its approach, up to `retreat_m`. A grasp at which
///    the hand collides is discarded; if none is left, no grasp can be reached.
/// 2. Inverse kinematics finds goals, for grasps drawn with probability in proportion to their free retreat. A goal brings its approach: the
///    configurations of the hand moving back, by inverse kinematics, as far as each motion is proven.
/// 3. The trees grow as in `rrt-connect`, with probability `p_approach` towards the beginning of an approach, else towards a uniform
///    random configuration.
///
/// One iteration is one growth, or one batch of inverse kinematics before there is a goal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ApproachRrt {
    /// Probability of a growth towards the beginning of an approach, in [0, 1]. Default 0.2.
    pub p_approach: f64,
    /// Greatest free retreat that counts, in metres. Default 0.2: the depth of most shelves.
    pub retreat_m: f64,
    /// Length of a step of an approach, in metres. Default 0.02.
    pub back_m: f64,
    /// Maximum motion of the origin of any link frame in a step, in metres. Default 0.1, that of the released planners.
    pub step_m: f64,
    /// Number of goals that suffice. Default 100.
    pub goals: usize,
}

impl Default for ApproachRrt {
    fn default() -> Self {
        Self { p_approach: 0.2, retreat_m: 0.2, back_m: 0.02, step_m: RELEASED_STEP_M, goals: 100 }
    }
}

impl Planner for ApproachRrt {
    fn name(&self) -> &'static str {
        "approach-rrt"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        const STEPS: [usize; 2] = [1, 1000];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast of NaN is 0")]
        let steps = (self.retreat_m / self.back_m) as usize;
        Ranges::of(self.name())
            .share("p_approach", self.p_approach)?
            .positive("retreat_m", self.retreat_m)?
            .positive("back_m", self.back_m)?
            .count_between("retreat_m / back_m", steps, STEPS)?
            .positive("step_m", self.step_m)?
            .count("goals", self.goals, usize::MAX)?;
        Ok(())
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        self.check()?;
        let mut search = Search::new(problem, budget, seed, observer);
        let (cell, goal) = (problem.exact_cell(self.name())?, problem.some_goal()?);
        let mut sides = Sides {
            settings: self,
            problem,
            cell,
            trees: Bidirectional::new(problem, Growth::Step { step_m: self.step_m }),
            scratch: cell.scratch(),
            beginnings: Vec::new(),
            goals: 0,
        };
        let ended = sides.run(goal, &mut search);
        search.statistics.nodes = sides.trees.nodes() as u64;
        Ok(search.report(ended))
    }
}

/// Grasp pose with its free retreat.
struct Side {
    world_from_gripper: Pose,
    /// Free retreat and that of all poses before it, in metres.
    sum_m: f64,
}

struct Sides<'a> {
    settings: &'a ApproachRrt,
    problem: &'a Problem,
    cell: &'a Cell,
    trees: Bidirectional<'a>,
    scratch: Scratch,
    /// Beginnings of the approaches.
    beginnings: Vec<Vec<f64>>,
    goals: usize,
}

impl Sides<'_> {
    fn run(&mut self, goal: &Goal, search: &mut Search) -> Result<Path, Outcome> {
        let start = self.problem.start();
        if !self.cell.is_free(start, &mut self.scratch) {
            return Err(Outcome::StartInvalid);
        }
        self.trees.add_start(start, search);
        match goal {
            Goal::Configurations(goals) => {
                search.statistics.collision_checks += goals.len() as u64;
                for goal in goals.iter().filter(|goal| self.cell.is_free(goal, &mut self.scratch)) {
                    self.trees.add_goal(goal, search);
                    self.goals += 1;
                }
                if self.goals == 0 {
                    return Err(Outcome::GoalsInvalid);
                }
                loop {
                    search.begin_iteration()?;
                    if let Some((path, _)) = self.grow(search) {
                        return Ok(path);
                    }
                }
            }
            Goal::Grasps(grasps) => {
                let open = open_gripper_poses(self.cell, grasps, &mut self.scratch);
                self.all_poses(open, search)
            }
            Goal::Regions(regions) => {
                let open = open_region_poses(self.cell, regions, &mut search.random, &mut self.scratch);
                if open.is_empty() {
                    return Err(Outcome::GaveUp);
                }
                self.all_poses(open, search)
            }
        }
    }

    fn all_poses(&mut self, open: Vec<(usize, Pose)>, search: &mut Search) -> Result<Path, Outcome> {
        /// Iterations between two batches, once there is a goal.
        const EVERY: u64 = 8;
        // 1.
        let sides = self.sides(open);
        if sides.is_empty() {
            return Err(Outcome::NoReachableGrasp);
        }
        let robot = self.problem.robot().as_ref();
        let mut batch = IkBatch::new(robot, IkSettings::default());
        let mut solver = IkSolver::new(robot, IkSettings::default());
        let mut waited = 0;
        loop {
            search.begin_iteration()?;
            waited += 1;
            if self.goals == 0 || (self.goals < self.settings.goals && waited >= EVERY) {
                waited = 0;
                self.draw(&sides, (&mut batch, &mut solver), search);
            }
            if self.goals > 0
                && let Some((path, _)) = self.grow(search)
            {
                return Ok(path);
            }
        }
    }

    /// Returns the poses, at which the hand alone is free, with their free retreat.
    fn sides(&mut self, open: Vec<(usize, Pose)>) -> Vec<Side> {
        /// Free retreat that every grasp has, in metres, so that none has probability 0.
        const LEAST_M: f64 = 0.01;
        let filter = self.problem.grasp_filter();
        let mut sum_m = 0.0;
        let mut sides = Vec::new();
        for (_, world_from_gripper) in open {
            if filter.is_some_and(|filter| filter.fault_of(&world_from_gripper).is_some()) {
                continue;
            }
            let back = backward(&world_from_gripper, self.settings);
            let steps = back.take_while(|pose| self.cell.hand_is_free(pose, &mut self.scratch)).count();
            sum_m += LEAST_M + self.settings.back_m * steps as f64;
            sides.push(Side { world_from_gripper, sum_m });
        }
        sides
    }

    /// Performs 2 of [`ApproachRrt`] for one batch of inverse kinematics.
    fn draw(&mut self, sides: &[Side], (batch, solver): (&mut IkBatch, &mut IkSolver), search: &mut Search) {
        let begin = now();
        let total_m = sides.last().map_or(0.0, |side| side.sum_m);
        let chosen: [usize; IK_BATCH] = std::array::from_fn(|attempt| {
            let drawn_m = search.random.uniform() * total_m;
            let chosen = sides.partition_point(|side| side.sum_m <= drawn_m).min(sides.len() - 1);
            batch.draw(attempt, &sides[chosen].world_from_gripper, &mut search.random);
            chosen
        });
        batch.run(IK_BATCH);
        search.statistics.ik_attempts += IK_BATCH as u64;
        for (attempt, chosen) in chosen.into_iter().enumerate() {
            let Some(mut q) = batch.solution(attempt).map(|solution| solution.q) else { continue };
            self.problem.robot().turn_towards(self.problem.start(), &mut q);
            search.statistics.collision_checks += 1;
            if self.goals < self.settings.goals && self.cell.is_free(&q, &mut self.scratch) {
                self.trees.add_goal(&q, search);
                self.add_way_in(&sides[chosen].world_from_gripper, q, solver, search);
                self.goals += 1;
                search.statistics.goals_tried += 1;
            }
        }
        search.statistics.ik_time_s += begin.elapsed().as_secs_f64();
    }

    /// Adds the configurations of the hand moving back from the last goal.
    fn add_way_in(
        &mut self,
        world_from_gripper: &Pose,
        goal: Vec<f64>,
        solver: &mut IkSolver,
        search: &mut Search,
    ) {
        let mut way = vec![goal];
        for pose in backward(world_from_gripper, self.settings) {
            let Some(last) = way.last() else { break };
            let Some(next) = solver.step_from(&pose, last) else { break };
            search.statistics.collision_checks += 1;
            if !self.cell.motion_is_free(last, &next, &mut self.scratch).is_proven() {
                break;
            }
            way.push(next);
        }
        self.trees.add_branch(self.goals, &way[1..], search);
        self.beginnings.extend(way.pop());
    }

    /// Performs 3 of [`ApproachRrt`].
    fn grow(&mut self, search: &mut Search) -> Option<(Path, usize)> {
        let is_approach = search.random.uniform() < self.settings.p_approach && !self.beginnings.is_empty();
        let sample = if is_approach {
            self.beginnings[search.random.index(self.beginnings.len())].clone()
        } else {
            search.sample()
        };
        self.trees.grow_towards(&sample, search)
    }
}

/// Returns the poses of the gripper moving back from a grasp along its approach, by steps up to the greatest retreat.
fn backward<'a>(
    world_from_gripper: &'a Pose,
    settings: &ApproachRrt,
) -> impl Iterator<Item = Pose> + use<'a> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "settings bound the number")]
    let count = (settings.retreat_m / settings.back_m) as u32;
    let back_m = settings.back_m;
    (1..=count).map(move |step| world_from_gripper * Pose::translation(0.0, 0.0, -f64::from(step) * back_m))
}
