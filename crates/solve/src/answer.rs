use cranny_grasp::ScoreKind;
use cranny_path::Audit;
use cranny_plan::{Budget, Improvement, NoGrasp, OptimiseSettings, Outcome, Statistics};
use cranny_task::{ConfigurationFault, Criterion, GraspFailure, NotChecked, Segment, Stage, joined};

use crate::{Hold, Robustness, TaskTrajectory, Tilt, ToolSlack};

/// What came of a request: everything that is told of it anywhere.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Name of the planner.
    pub planner: String,
    /// All its settings.
    pub settings: serde_json::Value,
    /// What counted as solved.
    pub criterion: Criterion,
    /// Which score of the grasps counted.
    pub score: ScoreKind,
    /// Least score of the grasps that were goals, if that was asked.
    pub min_score: Option<f64>,
    /// Number of grasps that were excluded by it.
    pub below_min_score: Option<usize>,
    /// Under `paper`: the value of `½·mm + ½·deg` below which the gripper has arrived.
    pub goal_threshold: Option<f64>,
    /// What the search was allowed to spend.
    pub budget: Budget,
    /// What the random numbers were drawn from.
    pub seed: u64,
    /// Names of the joints, in the order of every way point.
    pub joint_names: Vec<String>,
    /// How the search ended.
    pub outcome: Outcome,
    /// The stages that were asked; empty where the goal of the problem is all.
    pub stages: Vec<Stage>,
    /// The path, piece by piece; empty where there is none.
    pub segments: Vec<Segment>,
    /// What the judge says of it.
    pub audit: Option<Audit>,
    /// When it is run through; `None` for one that does not hold, a robot without the limits for it, or where nobody
    /// asked.
    pub timed: Option<Timed>,
    /// Why a path of this robot gets no time; `None` where it does, or nobody asked.
    pub untimed: Option<String>,
    /// How far things may be from where the path has them, if it holds and that was asked.
    pub robustness: Option<Robustness>,
    /// Length, in the plain norm of the joints, that every path of the task has at least, of a path that holds, if that was
    /// asked and is known ([`least_length`](crate::least_length)).
    pub least_length: Option<f64>,
    /// Tilt of what is held, of a path that holds, where it is limited.
    pub tilt: Option<Tilt>,
    /// Distance of the tool within each of its bounds, of a path that holds.
    pub tool: Vec<ToolSlack>,
    /// Factor of the hold that was demanded, if one was.
    pub hold_demanded: Option<f64>,
    /// Firmness with which the hand holds what it carries, of a path that holds; `None` where nothing is carried, or it
    /// cannot be computed.
    pub hold: Option<Hold>,
    /// How the path was shortened, if it was.
    pub shortening: Option<Shortening>,
    /// How it became better after the first search, if anybody tried.
    pub optimisation: Option<Optimisation>,
    /// Cost of the search, over all stages; of a single stage that of the first search, where others followed.
    pub statistics: Statistics,
    /// What stood between the robot and each grasp, from a planner that keeps account of it; empty if solved.
    pub failures: Vec<GraspFailure>,
    /// All reasons why each goal configuration is refused, if all of them are.
    pub goal_faults: Vec<Vec<ConfigurationFault>>,
    /// Why no grasp was taken at all, after a search without a path in which the arm came to none.
    pub no_grasp: Option<NoGrasp>,
    /// Pairs that touch and were not compared: the whole answer holds except for these.
    pub not_checked: Vec<NotChecked>,
}

/// A path's time, and what it took to find it.
#[derive(Clone, Debug)]
pub struct Timed {
    /// Where the robot is at each instant, and what its hand does.
    pub trajectory: TaskTrajectory,
    /// Seconds that it took to compute.
    pub time_s: f64,
}

/// How a path was shortened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shortening {
    /// Random changes of one path that were tried at most, drawn from the seed of the request.
    pub attempts: usize,
    /// Further searches for a better path.
    pub searches: u64,
    /// Seconds that it took.
    pub time_s: f64,
}

/// How a path was bettered after the first search.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimisation {
    /// What was asked.
    pub settings: OptimiseSettings,
    /// How long it went on, in seconds.
    pub time_s: f64,
    /// Iterations of all searches together.
    pub iterations: u64,
    /// The cost over time: of the first path, and of every better one.
    pub improvements: Vec<Improvement>,
}

impl Answer {
    /// The same answer to a problem with more grasps, where those that it counts from 0 are these.
    pub(crate) fn with_grasp_numbers(mut self, numbers: &[usize], count: usize) -> Self {
        if let Some(audit) = &mut self.audit {
            let goals = audit.picks.iter_mut().filter_map(|pick| pick.goal.as_mut());
            for goal in goals.chain(&mut audit.goal) {
                goal.grasp = numbers[goal.grasp];
            }
        }
        // Of another object the grasps are the planner's own.
        for failure in &mut self.failures {
            failure.grasp = numbers.get(failure.grasp).copied().unwrap_or(failure.grasp);
        }
        if let Some(NoGrasp::OutOfReach(miss)) = &mut self.no_grasp {
            miss.grasp = miss.grasp.map(|grasp| numbers[grasp]);
        }
        self.below_min_score = Some(count - numbers.len());
        self
    }

    /// Whether there is a path, and the judge finds that it meets the criterion.
    pub fn is_solved(&self) -> bool {
        self.outcome == Outcome::Solved && self.is_valid()
    }

    /// Whether the judge finds nothing wrong with the path.
    pub fn is_valid(&self) -> bool {
        self.audit.as_ref().is_some_and(|audit| audit.valid)
    }

    /// All way points (m, rad; one value per joint), from the start to the goal: where two segments meet, one.
    pub fn waypoints(&self) -> Vec<Vec<f64>> {
        joined(&self.segments)
    }
}
