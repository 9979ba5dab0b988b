use std::time::Instant;

use cranny_grasp::GraspSet;
use cranny_robot::{Jacobian, Robot, Twist, damped_pseudo_inverse_step};
use cranny_spatial::{Pose, PoseDifference, Stream};
use serde::{Deserialize, Serialize};

use crate::baseline_check::BaselineCheck;
use crate::goal_meter::GoalMeter;
use crate::planner::Clock;
use crate::search_tree::SearchTree;
use crate::step::{RELEASED_STEP_M, Stepper};
use crate::{Budget, Goal, Observer, Outcome, PlanError, PlanReport, Planner, Problem, Statistics};

/// J⁺-RRT (Vahrenkamp, Asfour & Dillmann 2009; Shkolnik & Tedrake 2009; the paper's §V.A): one tree from the
/// start that grows towards random configurations and, now and then, towards a grasp by the pseudo-inverse
/// of the Jacobian.
///
/// 1. With probability `1 − p_goal`, one step from the nearest node towards a uniform random configuration.
/// 2. Otherwise pick a grasp, and from the node that is nearest to it take pseudo-inverse steps until the
///    gripper arrives, the motion is blocked, or it comes no nearer.
/// 3. Every new node is measured against all grasps; the first that has arrived ends the search.
///
/// One iteration is one pass through 1 or 2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JPlusRrt {
    /// Probability of step 2, in [0, 1]. Default 0.01, the paper's.
    pub p_goal: f64,
    /// How far the origin of any link frame moves in a step, in metres. Default 0.1, the released value.
    pub step_m: f64,
    /// How the grasp of step 2 is picked. Default: uniformly.
    pub choice: GraspChoice,
    /// Damping λ of the pseudo-inverse. Default 0.05: as much as keeps steps near singularities bounded
    /// without slowing them elsewhere.
    pub damping: f64,
}

/// How a planner picks a grasp to go for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GraspChoice {
    /// Every grasp is as likely as any other.
    #[default]
    Uniform,
    /// With probability proportional to the score; a set without scores is drawn from uniformly.
    ByScore,
}

impl Default for JPlusRrt {
    fn default() -> Self {
        Self { p_goal: 0.01, step_m: RELEASED_STEP_M, choice: GraspChoice::Uniform, damping: 0.05 }
    }
}

/// The released planners let the rotation enter once `d` is at most this.
const ROTATION_ENTERS_BELOW: f64 = 100.0;

impl Planner for JPlusRrt {
    fn name(&self) -> &'static str {
        "j-plus-rrt"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let mut clock = Clock::new(budget);
        let Goal::Grasps(grasps) = problem.some_goal()? else {
            return Err(PlanError::Goal { planner: "j-plus-rrt", needs: "grasps" });
        };
        let mut search = Search::new(self, problem, grasps, seed);
        let ended = search.run(&mut clock, observer);
        let mut statistics = search.statistics;
        statistics.nodes = search.tree.len() as u64;
        statistics.planning_time_s = clock.elapsed_s();
        Ok(PlanReport::of(ended.map(|node| search.tree.path_to(node)), statistics))
    }
}

struct Search<'a> {
    settings: &'a JPlusRrt,
    problem: &'a Problem,
    robot: &'a Robot,
    grasps: &'a GraspSet,
    random: Stream,
    tree: SearchTree,
    meter: GoalMeter,
    stepper: Stepper,
    check: BaselineCheck<'a>,
    jacobian: Jacobian,
    statistics: Statistics,
}

impl<'a> Search<'a> {
    fn new(settings: &'a JPlusRrt, problem: &'a Problem, grasps: &'a GraspSet, seed: u64) -> Self {
        let robot = problem.robot().as_ref();
        Self {
            settings,
            problem,
            robot,
            grasps,
            random: Stream::new(seed, 0),
            tree: SearchTree::new(problem.start()),
            meter: GoalMeter::new(grasps),
            stepper: Stepper::new(robot),
            check: BaselineCheck::of(problem),
            jacobian: robot.empty_jacobian(),
            statistics: Statistics::default(),
        }
    }

    /// The node at which the search arrived, or why it ended without.
    fn run(&mut self, clock: &mut Clock, observer: &mut dyn Observer) -> Result<usize, Outcome> {
        let start = self.problem.start().to_vec();
        if !self.check.is_free(&start) {
            return Err(Outcome::StartInvalid);
        }
        observer.node_added(0, &start, None);
        let mut frames = self.robot.frames();
        self.robot.forward_kinematics(&start, &mut frames);
        if self.measure(0, frames.link(self.robot.tip())).is_some() {
            return Ok(0);
        }
        let mut sample = start;
        loop {
            if let Some(outcome) = clock.verdict(self.statistics.iterations, observer) {
                return Err(outcome);
            }
            self.statistics.iterations += 1;
            let arrived = if self.random.uniform() < self.settings.p_goal {
                self.reach_for_a_grasp(observer)
            } else {
                for (value, limits) in sample.iter_mut().zip(self.robot.limits()) {
                    *value = self.random.uniform_between(limits.lower, limits.upper);
                }
                self.explore(&sample, observer)
            };
            if let Some(node) = arrived {
                return Ok(node);
            }
        }
    }

    /// Step 1.
    fn explore(&mut self, sample: &[f64], observer: &mut dyn Observer) -> Option<usize> {
        let begin = Instant::now();
        let nearest = self.tree.nearest(sample);
        self.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        let (_, arrived) = self.grow(nearest, sample, observer)?;
        arrived
    }

    /// Step 2.
    fn reach_for_a_grasp(&mut self, observer: &mut dyn Observer) -> Option<usize> {
        let picked = self.pick();
        let goal = &self.grasps.grasps()[picked];
        let mut node = self.meter.nearest_node(picked);
        let mut frames = self.robot.frames();
        let mut step = vec![0.0; self.robot.dof()];
        let mut target = step.clone();
        let mut nearest = f64::INFINITY;
        loop {
            let q = self.tree.q(node);
            self.robot.forward_kinematics(q, &mut frames);
            let gripper = frames.link(self.robot.tip());
            let d = goal.difference(gripper).paper_metric();
            if d >= nearest {
                return None;
            }
            nearest = d;
            // Of the grasp and its twin the one that is turned less.
            let twin = goal.twin();
            let turn = |pose: &Pose| PoseDifference::between(gripper, pose).rotation_rad;
            let wanted = if turn(&goal.world_from_gripper) <= turn(&twin.world_from_gripper) {
                goal.world_from_gripper
            } else {
                twin.world_from_gripper
            };
            let mut twist = Twist::zeros();
            let translation = wanted.translation.vector - gripper.translation.vector;
            twist.fixed_rows_mut::<3>(0).copy_from(&translation);
            if d <= ROTATION_ENTERS_BELOW {
                let rotation = (wanted.rotation * gripper.rotation.inverse()).scaled_axis();
                twist.fixed_rows_mut::<3>(3).copy_from(&rotation);
            }
            self.robot.jacobian(&frames, self.robot.tip(), &mut self.jacobian);
            if d > ROTATION_ENTERS_BELOW {
                // Far away only the position counts: the rotation is free, not held.
                self.jacobian.fixed_rows_mut::<3>(3).fill(0.0);
            }
            if !damped_pseudo_inverse_step(&self.jacobian, &twist, self.settings.damping, &mut step) {
                return None;
            }
            for ((target, q), step) in target.iter_mut().zip(q).zip(&step) {
                *target = q + step;
            }
            let (added, arrived) = self.grow(node, &target, observer)?;
            if arrived.is_some() {
                return arrived;
            }
            node = added;
        }
    }

    /// Adds a node one step from `parent` towards `target`, if that is free. Step 3: returns it, and again
    /// if the gripper has arrived there.
    fn grow(
        &mut self,
        parent: usize,
        target: &[f64],
        observer: &mut dyn Observer,
    ) -> Option<(usize, Option<usize>)> {
        let from = self.tree.q(parent);
        self.stepper.towards(self.robot, from, target, self.settings.step_m);
        let (q, frames) = (self.stepper.q(), self.stepper.frames());
        self.statistics.collision_checks += 1;
        let begin = Instant::now();
        let is_free = self.check.edge_to_frames_is_free(from, q, frames);
        self.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        if !is_free {
            return None;
        }
        let node = self.tree.add(q, parent);
        observer.node_added(0, q, Some(parent));
        let gripper = *self.stepper.frames().link(self.robot.tip());
        Some((node, self.measure(node, &gripper)))
    }

    fn measure(&mut self, node: usize, gripper: &Pose) -> Option<usize> {
        let problem = self.problem;
        self.meter.measure(node, gripper, |difference| problem.is_arrival(difference)).map(|_| node)
    }

    fn pick(&mut self) -> usize {
        match self.settings.choice {
            GraspChoice::Uniform => self.random.index(self.grasps.len()),
            GraspChoice::ByScore => {
                let weight = |index: usize| self.grasps.grasps()[index].score.unwrap_or(0.0);
                let total: f64 = (0..self.grasps.len()).map(weight).sum();
                let mut left = self.random.uniform() * total;
                let passes = |index: &usize| {
                    left -= weight(*index);
                    left < 0.0
                };
                // Without a score anywhere every grasp is as good as any other.
                match (0..self.grasps.len()).find(passes) {
                    Some(picked) => picked,
                    None => self.random.index(self.grasps.len()),
                }
            }
        }
    }
}
