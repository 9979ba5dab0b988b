use std::time::Duration;

use cranny_task::{GraspFailure, Problem};
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

use crate::PlanError;

/// How much a planner may spend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// At most so many iterations (each planner says what one is). Default: no limit.
    pub iterations: u64,
    /// At most so much wall-clock time. It may only cut short the search that the seed and the iterations
    /// determine. Default: 120 s, the paper's limit.
    pub time: Duration,
}

impl Default for Budget {
    fn default() -> Self {
        Self { iterations: u64::MAX, time: Duration::from_mins(2) }
    }
}

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Outcome {
    /// There is a path, and it meets the criterion.
    Solved,
    /// The budget was spent before a path was found.
    BudgetExhausted,
    /// The observer asked to stop.
    Cancelled,
    /// The planner has nothing left to try, though its budget is not spent: it says nothing of whether there is a path.
    GaveUp,
    /// The start is in collision or outside the joint limits.
    StartInvalid,
    /// Every goal configuration is in collision or outside the joint limits.
    GoalsInvalid,
    /// No grasp can be reached at all: each is excluded for certain, or wherever the target was sampled it is wider than the
    /// hand opens.
    NoReachableGrasp,
}

impl Outcome {
    /// What files and `--json` call it.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// What it means, in a few words.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::BudgetExhausted => "time or iterations ran out",
            Self::Cancelled => "the search was stopped",
            Self::GaveUp => "every goal was tried as long as the planner does",
            Self::StartInvalid => "the start is in collision or beyond a joint limit",
            Self::GoalsInvalid => "every goal is in collision or beyond a joint limit",
            Self::NoReachableGrasp => "no grasp can be reached",
        }
    }
}

/// What a search cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Statistics {
    /// Iterations, as the planner counts them.
    pub iterations: u64,
    /// Nodes that were added to all search trees together.
    pub nodes: u64,
    /// Configurations and edges that were checked for collision.
    pub collision_checks: u64,
    /// Inverse-kinematics attempts.
    pub ik_attempts: u64,
    /// Goals (grasps or configurations) that were tried one after the other.
    pub goals_tried: u64,
    /// Seconds from the problem to the proven path.
    pub planning_time_s: f64,
    /// Seconds of it spent on inverse kinematics and the validity of its solutions.
    pub ik_time_s: f64,
    /// Seconds of it spent on collision checks during the search, and on proofs where the tree grows on
    /// proven edges.
    pub collision_time_s: f64,
    /// Seconds of it spent on proving a path that was found, where that is apart from the search.
    #[serde(default)]
    pub proof_time_s: f64,
    /// Seconds of it spent on the nearest neighbours. `reach` times this and the collision checks in one iteration of
    /// sixteen, and tells what follows for all.
    pub nearest_time_s: f64,
}

impl Statistics {
    /// The sum of this and the cost of another search.
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

/// What a planner found.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanReport {
    /// How the search ended.
    pub outcome: Outcome,
    /// Way points from the start to the goal; empty unless solved.
    pub path: Vec<Vec<f64>>,
    /// What it cost.
    pub statistics: Statistics,
    /// What stood between the robot and each grasp, from planners that keep account of it; empty if solved.
    pub failures: Vec<GraspFailure>,
}

impl PlanReport {
    /// The report of a search that ended with a path of way points (m, rad; one value per joint), or with a reason
    /// why there is none.
    pub fn of(ended: Result<Vec<Vec<f64>>, Outcome>, statistics: Statistics) -> Self {
        let (outcome, path) = match ended {
            Ok(path) => (Outcome::Solved, path),
            Err(outcome) => (outcome, Vec::new()),
        };
        Self { outcome, path, statistics, failures: Vec::new() }
    }
}

/// Watches a search. Every method has a default that does nothing, so watching nothing costs nothing.
pub trait Observer {
    /// A node was added to tree `tree` (0: from the start) at `q` (m, rad; one per joint), below node `parent` of the
    /// same tree.
    fn node_added(&mut self, _tree: usize, _q: &[f64], _parent: Option<usize>) {}

    /// Node `node` of tree `tree` was cut off, with all that grew from it: nodes are counted from 0 in the order in which
    /// they were added to the tree, and keep their numbers.
    fn node_cut(&mut self, _tree: usize, _node: usize) {}

    /// So many iterations are done.
    fn progress(&mut self, _iterations: u64) {}

    /// The search is over: whatever follows does something else with its path.
    fn search_ended(&mut self) {}

    /// Whether the search should end with [`Outcome::Cancelled`].
    fn should_stop(&self) -> bool {
        false
    }
}

/// Watches nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unobserved;

impl Observer for Unobserved {}

/// A search for paths to the goals of a problem, one after another: the caller decides what each is good for.
///
/// Pull, not push: a task goes on from the end of a path (closing a hand, carrying what it holds) with searches of its own,
/// which have a budget and an account; inside a callback of the first search they had neither.
pub trait PathSearch {
    /// The next path, or the reason for which there is none, with the statistics so far. Budget and time go on where the last
    /// call ended.
    ///
    /// # Errors
    /// As [`Planner::plan`].
    fn next(&mut self, observer: &mut dyn Observer) -> Result<PlanReport, PlanError>;

    /// Leaves out the goal at which the last path ends.
    fn reject(&mut self);
}

/// A planner: a pure function of problem, budget and seed. The same three give the same path, on any
/// machine, unless time cuts the search short.
pub trait Planner: Send + Sync {
    /// The name by which the registry knows it.
    fn name(&self) -> &'static str;

    /// Its settings, for the record.
    fn settings(&self) -> serde_json::Value;

    /// Whether its settings lie where it can use them ([`Ranges`](crate::Ranges)). The registry asks when it makes one,
    /// [`search`](crate::search) before it runs one. Default: whatever can be read is good.
    ///
    /// # Errors
    /// [`PlanError::Setting`], which names the setting and its range.
    fn check(&self) -> Result<(), PlanError> {
        Ok(())
    }

    /// Whether it makes grasps of its own: it solves problems without a set of grasps, and no others.
    fn makes_grasps(&self) -> bool {
        false
    }

    /// Its search, if that can go on from a path to others. Default: none, and for each further path it begins anew from
    /// another seed ([`begin_search`](crate::begin_search)).
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

    /// Looks for a path.
    ///
    /// # Errors
    /// [`PlanError`] if the problem is malformed or of a kind that this planner cannot take. That there is
    /// no path within the budget is an [`Outcome`].
    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError>;
}
