use cranny_grasp::ScoreKind;
use cranny_path::Audit;
use cranny_plan::{Budget, Improvement, NoGrasp, OptimiseSettings, Outcome, RefusedClaim, Statistics};
use cranny_task::{ConfigurationFault, Criterion, GraspFailure, NotChecked, Segment, Stage, joined};

use crate::{HoldFactors, Robustness, TaskTrajectory, Tilt, ToolSlack};

/// Result of [`solve`](crate::solve()): path, proof, timing and statistics.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Name of the planner.
    pub planner: String,
    /// Complete settings of the planner.
    pub settings: serde_json::Value,
    /// Criterion by which the problem counts as solved.
    pub criterion: Criterion,
    /// Score of the grasps that was used.
    pub score: ScoreKind,
    /// Least score of the goal grasps, if requested.
    pub min_score: Option<f64>,
    /// Number of grasps excluded by `min_score`.
    pub below_min_score: Option<usize>,
    /// Under `paper`: the value of `½·mm + ½·deg` below which the gripper has arrived.
    pub goal_threshold: Option<f64>,
    /// Budget of the search.
    pub budget: Budget,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Names of the joints, in the order of every way point.
    pub joint_names: Vec<String>,
    /// Outcome of the search.
    pub outcome: Outcome,
    /// Requested stages; empty if the task is the goal of the problem alone.
    pub stages: Vec<Stage>,
    /// Path in segments; empty if there is none.
    pub segments: Vec<Segment>,
    /// Result of the audit.
    pub audit: Option<Audit>,
    /// Trajectory of the path; `None` for an invalid path, a robot without the required limits, or if none was requested.
    pub timed: Option<Timed>,
    /// Reason why no path of this robot can be timed; `None` if paths can be timed, or no trajectory was requested.
    pub untimed: Option<String>,
    /// Tolerated deviations from the plan, if the path is valid and they were requested.
    pub robustness: Option<Robustness>,
    /// Lower bound on the length of all paths of the task, in the plain norm of `q` (m and rad alike), for a valid path, if
    /// requested and known ([`least_length`](crate::least_length)).
    pub least_length: Option<f64>,
    /// Tilt of the held object along a valid path, if it is limited.
    pub tilt: Option<Tilt>,
    /// Distance of the tool within each of its bounds along a valid path.
    pub tool: Vec<ToolSlack>,
    /// Required factor of the hold, if there is one.
    pub hold_demanded: Option<f64>,
    /// Firmness of the hold on the carried object along a valid path; `None` if nothing is carried, or it cannot be computed.
    pub hold: Option<HoldFactors>,
    /// Shortening of the path, if done.
    pub shortening: Option<Shortening>,
    /// Optimisation of the path after the first search, if done.
    pub optimisation: Option<Optimisation>,
    /// Statistics of the first search, over all its stages; those of other seeds that followed are not counted.
    pub statistics: Statistics,
    /// Reason for the failure of each grasp, from a planner that records them; empty if solved.
    pub failures: Vec<GraspFailure>,
    /// All reasons why each goal configuration is refused, if all of them are.
    pub goal_faults: Vec<Vec<ConfigurationFault>>,
    /// Reason why no grasp was reached, if the search ended without reaching any.
    pub no_grasp: Option<NoGrasp>,
    /// Path that the planner claimed and the proof refused, if that is the outcome.
    pub refused: Option<RefusedClaim>,
    /// Pairs that were not compared, as exceptions to the answer ([`NotChecked::is_exception`]).
    pub not_checked: Vec<NotChecked>,
}

/// Trajectory of a path, and its computing time.
#[derive(Clone, Debug)]
pub struct Timed {
    /// Motion of the robot and of its hand over time.
    pub trajectory: TaskTrajectory,
    /// Computing time, in seconds.
    pub time_s: f64,
}

/// Statistics of the shortening of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shortening {
    /// Maximum number of random changes tried on one path, drawn from the seed of the request.
    pub attempts: usize,
    /// Number of further searches for a better path.
    pub searches: u64,
    /// Duration, in seconds.
    pub time_s: f64,
}

/// Statistics of the optimisation of a path after the first search.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimisation {
    /// Requested settings.
    pub settings: OptimiseSettings,
    /// Duration, in seconds.
    pub time_s: f64,
    /// Number of iterations of all searches together.
    pub iterations: u64,
    /// Cost over time: of the first path, and of each improvement.
    pub improvements: Vec<Improvement>,
}

impl Answer {
    /// Returns this answer with grasp indices mapped by `numbers` to those of the original set of `count` grasps.
    pub(crate) fn with_grasp_numbers(mut self, numbers: &[usize], count: usize) -> Self {
        if let Some(audit) = &mut self.audit {
            let goals = audit.picks.iter_mut().filter_map(|pick| pick.goal.as_mut());
            for goal in goals.chain(&mut audit.goal) {
                goal.grasp = numbers[goal.grasp];
            }
        }
        // For other objects the planner generates the grasps, so their indices stay.
        for failure in &mut self.failures {
            failure.grasp = numbers.get(failure.grasp).copied().unwrap_or(failure.grasp);
        }
        if let Some(NoGrasp::OutOfReach(miss)) = &mut self.no_grasp {
            miss.grasp = miss.grasp.map(|grasp| numbers[grasp]);
        }
        self.below_min_score = Some(count - numbers.len());
        self
    }

    /// Returns true if a path was found, and the audit confirms that it meets the criterion.
    pub fn is_solved(&self) -> bool {
        self.outcome == Outcome::Solved && self.is_valid()
    }

    /// Returns true if the audit finds no fault of the path.
    pub fn is_valid(&self) -> bool {
        self.audit.as_ref().is_some_and(|audit| audit.valid)
    }

    /// Returns all way points (m, rad; one value per joint), from start to goal; those shared by two segments appear once.
    pub fn waypoints(&self) -> Vec<Vec<f64>> {
        joined(&self.segments)
    }
}
