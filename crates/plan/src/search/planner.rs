use std::time::Duration;

use cranny_task::{GraspFailure, Problem};
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

use crate::{PlanError, RefusedClaim};

/// Limits of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Maximum number of iterations (each planner defines one). Default: no limit.
    pub iterations: u64,
    /// Maximum wall-clock time; it only cuts short the search that seed and iterations determine. Default: 120 s (the paper's).
    pub time: Duration,
}

impl Default for Budget {
    fn default() -> Self {
        Self { iterations: u64::MAX, time: Duration::from_mins(2) }
    }
}

/// Outcome of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Outcome {
    /// A path was found, and it meets the criterion.
    Solved,
    /// The budget was spent before a path was found.
    BudgetExhausted,
    /// The observer requested a stop.
    Cancelled,
    /// The planner has nothing left to try, before its budget is spent. A path may exist nevertheless.
    GaveUp,
    /// The start is in collision or outside the joint limits.
    StartInvalid,
    /// Every goal configuration is in collision or outside the joint limits.
    GoalsInvalid,
    /// The planner found a path that meets its own measure, and the proof refused it; the budget was spent before another.
    ClaimedNotProven,
    /// No grasp can be reached: each is provably excluded, or the target is wider than the hand opens at every sample.
    NoReachableGrasp,
    /// Every goal region lies provably beyond the reach of the arm.
    RegionOutOfReach,
}

impl Outcome {
    /// Returns the name used in files and `--json`.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Returns a description in a few words.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::BudgetExhausted => "time or iterations ran out",
            Self::Cancelled => "the search was stopped",
            Self::GaveUp => "every goal was tried up to the planner's limit",
            Self::StartInvalid => "the start is in collision or beyond a joint limit",
            Self::GoalsInvalid => "every goal is in collision or beyond a joint limit",
            Self::ClaimedNotProven => "claimed, not proven",
            Self::NoReachableGrasp => "no grasp can be reached",
            Self::RegionOutOfReach => "the goal region is beyond reach",
        }
    }
}

/// Statistics of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Statistics {
    /// Number of iterations, as the planner counts them.
    pub iterations: u64,
    /// Number of nodes added to all search trees together.
    pub nodes: u64,
    /// Number of configurations and edges checked for collision.
    pub collision_checks: u64,
    /// Number of inverse-kinematics attempts.
    pub ik_attempts: u64,
    /// Number of goals (grasps or configurations) tried one after the other.
    pub goals_tried: u64,
    /// Time from the problem to the proven path, in seconds.
    pub planning_time_s: f64,
    /// Time spent on inverse kinematics and the validity of its solutions, in seconds.
    pub ik_time_s: f64,
    /// Time spent on collision checks during the search, and on proofs if the tree grows along proven edges, in seconds.
    pub collision_time_s: f64,
    /// Time spent on the proof of a path, if that is separate from the search, in seconds.
    #[serde(default)]
    pub proof_time_s: f64,
    /// Time spent on nearest neighbours, in seconds. `reach` measures this and the collision checks in one of sixteen
    /// iterations, and extrapolates.
    pub nearest_time_s: f64,
}

impl Statistics {
    /// Returns the sum of these and the statistics of another search.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        Self {
            iterations: self.iterations + other.iterations,
            nodes: self.nodes + other.nodes,
            collision_checks: self.collision_checks + other.collision_checks,
            ik_attempts: self.ik_attempts + other.ik_attempts,
            goals_tried: self.goals_tried + other.goals_tried,
            planning_time_s: self.planning_time_s + other.planning_time_s,
            ik_time_s: self.ik_time_s + other.ik_time_s,
            collision_time_s: self.collision_time_s + other.collision_time_s,
            proof_time_s: self.proof_time_s + other.proof_time_s,
            nearest_time_s: self.nearest_time_s + other.nearest_time_s,
        }
    }
}

/// Result of a planner.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanReport {
    /// Outcome of the search.
    pub outcome: Outcome,
    /// Way points from the start to the goal (m, rad; one value per joint); empty unless solved.
    pub path: Vec<Vec<f64>>,
    /// Statistics of the search.
    pub statistics: Statistics,
    /// Obstacle to each grasp, from planners that record it; empty if solved.
    pub failures: Vec<GraspFailure>,
    /// Path that was claimed and refused, for [`Outcome::ClaimedNotProven`].
    pub refused: Option<RefusedClaim>,
}

impl PlanReport {
    /// Creates the report of a search that ended with a path (m, rad; one value per joint), or with the reason for its failure.
    pub fn of(ended: Result<Vec<Vec<f64>>, Outcome>, statistics: Statistics) -> Self {
        let (outcome, path) = match ended {
            Ok(path) => (Outcome::Solved, path),
            Err(outcome) => (outcome, Vec::new()),
        };
        Self { outcome, path, statistics, failures: Vec::new(), refused: None }
    }
}

/// Observer of a search. Every method does nothing by default.
pub trait Observer {
    /// Reports a new node of tree `tree` (0: from the start) at `q` (m, rad; one per joint), below node `parent` of this tree.
    fn node_added(&mut self, _tree: usize, _q: &[f64], _parent: Option<usize>) {}

    /// Reports that node `node` of tree `tree` was cut off with all its descendants. Nodes are numbered from 0 in the order in
    /// which they were added to the tree, and keep their numbers.
    fn node_cut(&mut self, _tree: usize, _node: usize) {}

    /// Reports the number of iterations completed.
    fn progress(&mut self, _iterations: u64) {}

    /// Reports the end of the search; only further processing of its path follows.
    fn search_ended(&mut self) {}

    /// Returns true if the search should end with [`Outcome::Cancelled`].
    fn should_stop(&self) -> bool {
        false
    }
}

/// Observer that ignores all reports.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unobserved;

impl Observer for Unobserved {}

/// Search for paths to the goals of a problem, one after another. The caller decides about each path, because a task continues
/// from the end of the path (closing the hand, carrying an object) with further searches, which need a budget and statistics of
/// their own. A callback of the first search could not provide these.
pub trait PathSearch {
    /// Returns the next path, or the reason why there is none, with the statistics of all calls. Budget and time carry over.
    ///
    /// # Errors
    /// As [`Planner::plan`].
    fn next(&mut self, observer: &mut dyn Observer) -> Result<PlanReport, PlanError>;

    /// Rejects the goal at which the last path ends.
    fn reject(&mut self);
}

/// Planner: a pure function of problem, budget and seed. Equal arguments give equal paths on any machine, unless time runs out.
pub trait Planner: Send + Sync {
    /// Returns its name in the registry.
    fn name(&self) -> &'static str;

    /// Returns its settings, for the record.
    fn settings(&self) -> serde_json::Value;

    /// Checks that its settings are in range ([`Ranges`](crate::Ranges)). The registry does so when it creates a planner,
    /// [`search`](crate::search) before it runs one. Default: all readable settings are valid.
    ///
    /// # Errors
    /// [`PlanError::Setting`], which names the setting and its range.
    fn check(&self) -> Result<(), PlanError> {
        Ok(())
    }

    /// Returns true if it generates grasps: it then solves only problems without a set of grasps.
    fn makes_grasps(&self) -> bool {
        false
    }

    /// Begins its search, if that can continue from one path to others. Default: `None`, so that each further path is a new
    /// search with another seed ([`begin_search`](crate::begin_search)).
    ///
    /// # Errors
    /// As [`Self::plan`].
    fn begin<'a>(
        &self,
        _problem: &'a Problem,
        _budget: &Budget,
        _seed: u64,
    ) -> Result<Option<Box<dyn PathSearch + 'a>>, PlanError> {
        Ok(None)
    }

    /// Searches for a path.
    ///
    /// # Errors
    /// [`PlanError`] if the problem is malformed or of a kind that this planner does not support. Finding no path within the
    /// budget is an [`Outcome`].
    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError>;
}
