use cranny_grasp::GraspSet;
use cranny_path::JointMetric;
use cranny_robot::{Jacobian, LinkFrames, Robot, Twist, damped_pseudo_inverse_step};
use cranny_spatial::{Pose, PoseDifference};
use cranny_task::{Goal, Problem};
use serde::{Deserialize, Serialize};

use crate::search::forest::Forest;
use crate::search::goal_meter::GoalMeter;
use crate::search::growth::{Grower, Growth};
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, Observer, Outcome, PlanError, PlanReport};

/// Choice of the grasp that a planner approaches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GraspChoice {
    /// Equal probability for every grasp.
    #[default]
    Uniform,
    /// Probability proportional to the score; uniform for a set without scores.
    ByScore,
}

/// Value of `d` up to which the released planners include the rotation.
const ROTATION_ENTERS_BELOW: f64 = 100.0;

/// Settings of a search with the pseudo-inverse of the Jacobian.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JacobianSettings {
    /// Probability of growing towards a grasp.
    pub p_goal: f64,
    /// Growth of the tree towards random configurations; towards a grasp it takes steps.
    pub growth: Growth,
    pub choice: GraspChoice,
    pub damping: f64,
}

/// Plans with one tree from the start that grows towards random configurations and, at times, towards a grasp by the
/// pseudo-inverse of the Jacobian ([`JPlusRrt`](crate::JPlusRrt)).
///
/// # Errors
/// [`TaskError::Goal`] for a problem without grasps, [`TaskError::NoGoal`].
pub(crate) fn plan_by_jacobian(
    planner: &'static str,
    settings: JacobianSettings,
    problem: &Problem,
    (budget, seed): (&Budget, u64),
    observer: &mut dyn Observer,
) -> Result<PlanReport, PlanError> {
    let mut search = Search::new(problem, budget, seed, observer);
    let Goal::Grasps(grasps) = problem.some_goal()? else {
        return Err(cranny_task::TaskError::Goal { planner, needs: "grasps" }.into());
    };
    let mut tree = JacobianTree::new(settings, problem, grasps);
    let ended = tree.run(&mut search);
    search.statistics.nodes = tree.nodes.len() as u64;
    Ok(search.report(ended.map(|node| tree.nodes.path_to(node))))
}

struct JacobianTree<'a> {
    settings: JacobianSettings,
    problem: &'a Problem,
    robot: &'a Robot,
    grasps: &'a GraspSet,
    nodes: Forest,
    meter: GoalMeter,
    grower: Grower<'a>,
    jacobian: Jacobian,
    frames: LinkFrames,
}

impl<'a> JacobianTree<'a> {
    fn new(settings: JacobianSettings, problem: &'a Problem, grasps: &'a GraspSet) -> Self {
        let robot = problem.robot().as_ref();
        Self {
            settings,
            problem,
            robot,
            grasps,
            nodes: Forest::new(robot.dof(), JointMetric::plain(robot.dof())),
            meter: GoalMeter::new(grasps),
            grower: Grower::new(problem, settings.growth),
            jacobian: robot.empty_jacobian(),
            frames: robot.frames(),
        }
    }

    /// Returns the node at which the search arrived, or the reason for its failure.
    fn run(&mut self, search: &mut Search) -> Result<usize, Outcome> {
        let start = self.problem.start();
        if !self.grower.check.is_free(start) {
            return Err(Outcome::StartInvalid);
        }
        let (root, arrived) = self.add(start, None, search);
        if arrived {
            return Ok(root);
        }
        loop {
            search.begin_iteration()?;
            let arrived = if search.random.uniform() < self.settings.p_goal {
                self.reach_for_a_grasp(search)
            } else {
                self.explore(search)
            };
            if let Some(node) = arrived {
                return Ok(node);
            }
        }
    }

    /// Grows from the nearest node towards a random configuration.
    fn explore(&mut self, search: &mut Search) -> Option<usize> {
        let sample = search.sample();
        let begin = now();
        let nearest = self.nodes.nearest(&sample)?;
        search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
        let from = self.nodes.q(nearest).to_vec();
        let grown = self.grower.grow(&from, &sample, true, search);
        for branch in std::iter::once(&grown.ahead).chain(&grown.aside) {
            let mut parent = nearest;
            for q in &branch.nodes {
                let (node, arrived) = self.add(q, Some(parent), search);
                if arrived {
                    return Some(node);
                }
                parent = node;
            }
        }
        None
    }

    /// Takes pseudo-inverse steps to a grasp from its nearest node until the gripper arrives, is blocked or comes no closer.
    fn reach_for_a_grasp(&mut self, search: &mut Search) -> Option<usize> {
        let picked = self.pick(search);
        let goal = &self.grasps.grasps()[picked];
        let mut node = self.meter.nearest_node(picked);
        let mut frames = self.robot.frames();
        let mut step = vec![0.0; self.robot.dof()];
        let mut target = step.clone();
        let mut nearest = f64::INFINITY;
        loop {
            let q = self.nodes.q(node).to_vec();
            self.robot.forward_kinematics(&q, &mut frames);
            let gripper = frames.link(self.robot.tip());
            let d = goal.difference(gripper).paper_metric();
            if d >= nearest {
                return None;
            }
            nearest = d;
            // The goal is the grasp or its twin, whichever needs less rotation.
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
                // Far away only the position counts: the rotation is unconstrained.
                self.jacobian.fixed_rows_mut::<3>(3).fill(0.0);
            }
            if !damped_pseudo_inverse_step(&self.jacobian, &twist, self.settings.damping, &mut step) {
                return None;
            }
            for ((target, q), step) in target.iter_mut().zip(&q).zip(&step) {
                *target = q + step;
            }
            let end = self.grower.step(&q, &target, search)?.0;
            let (added, arrived) = self.add(&end, Some(node), search);
            if arrived {
                return Some(added);
            }
            node = added;
        }
    }

    /// Adds a node; returns it, and true if the gripper has arrived at a grasp there.
    fn add(&mut self, q: &[f64], parent: Option<usize>, search: &mut Search) -> (usize, bool) {
        search.observer.node_added(0, q, parent);
        let node = self.nodes.add(q, parent);
        let problem = self.problem;
        self.robot.tip_kinematics(q, &mut self.frames);
        let gripper = *self.frames.link(self.robot.tip());
        (node, self.meter.measure(node, &gripper, |difference| problem.is_arrival(difference)).is_some())
    }

    fn pick(&mut self, search: &mut Search) -> usize {
        match self.settings.choice {
            GraspChoice::Uniform => search.random.index(self.grasps.len()),
            GraspChoice::ByScore => {
                let weight = |index: usize| self.grasps.grasps()[index].score.unwrap_or(0.0);
                let total: f64 = (0..self.grasps.len()).map(weight).sum();
                let mut left = search.random.uniform() * total;
                let passes = |index: &usize| {
                    left -= weight(*index);
                    left < 0.0
                };
                // Without any score all grasps are equally good.
                match (0..self.grasps.len()).find(passes) {
                    Some(picked) => picked,
                    None => search.random.index(self.grasps.len()),
                }
            }
        }
    }
}
