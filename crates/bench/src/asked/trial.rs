use cranny_plan::{Outcome, Statistics};
use cranny_task::Criterion;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray};

/// One question to one planner: what is run again when it is replayed, and what is never counted twice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Id of the scenario.
    pub scenario: String,
    /// SHA-256 over the files of the scenario, in hexadecimal: two scenarios of one name stay apart.
    pub scenario_hash: String,
    /// Name of the planner, as the report shows it.
    pub planner: String,
    /// All its settings, as canonical JSON (sorted keys): two settings of one planner stay apart.
    pub settings: String,
    /// What counts as solved.
    pub criterion: Criterion,
    /// What the random numbers are drawn from.
    pub seed: u64,
    /// At most so many seconds.
    pub time_limit_s: f64,
    /// At most so many iterations; `None` where only time counts.
    pub iteration_limit: Option<u64>,
    /// The one goal of the scenario's IK set that was aimed at; `None` where the planner had all grasps.
    pub goal: Option<usize>,
}

impl Trial {
    /// The same text for the same trial and for no other.
    pub fn key(&self) -> String {
        serde_json::json!(self).to_string()
    }
}

/// How a trial ended. "Solved" is what the judge says, whatever the planner says.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, EnumString, IntoStaticStr, VariantArray,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum TrialOutcome {
    /// There is a path, and the judge finds that it meets the criterion.
    Solved,
    /// The planner's time or iterations were spent.
    BudgetExhausted,
    /// The planner ended without a path before its budget was spent.
    GaveUp,
    /// The search was stopped from outside.
    Cancelled,
    /// The start is in collision or outside the joint limits.
    StartInvalid,
    /// Every goal configuration is in collision or outside the joint limits.
    GoalsInvalid,
    /// The planner is certain that no grasp can be reached.
    NoReachableGrasp,
    /// The planner gave a path, and the judge finds that it does not meet the criterion.
    Rejected,
    /// The planner gave something that is no path.
    Garbled,
    /// The planner's process ended by itself.
    Crashed,
    /// The planner went on past its limit and was stopped.
    Hung,
    /// The planner took more memory than it was given.
    OutOfMemory,
    /// Somebody ended the worker by a signal: nothing is known of the trial.
    Killed,
}

impl TrialOutcome {
    /// How a search ended, unless the judge finds that it gave a path.
    pub(crate) fn without_path(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Solved | Outcome::BudgetExhausted => Self::BudgetExhausted,
            Outcome::Cancelled => Self::Cancelled,
            Outcome::GaveUp => Self::GaveUp,
            Outcome::StartInvalid => Self::StartInvalid,
            Outcome::GoalsInvalid => Self::GoalsInvalid,
            Outcome::NoReachableGrasp => Self::NoReachableGrasp,
        }
    }

    /// What files and reports call it.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A trial and how it went: one row of the results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialRecord {
    /// The question.
    pub trial: Trial,
    /// How it ended.
    pub outcome: TrialOutcome,
    /// What a person should know of it: the judge's first objection, the signal, the first bad line.
    pub detail: Option<String>,
    /// What the search cost. A foreign planner's `planning_time_s` is measured outside; what it does not tell
    /// is zero.
    pub statistics: Statistics,
    /// Length of the path in the plain norm of `q` (m and rad alike); `None` unless solved.
    pub path_length: Option<f64>,
    /// The least clearance along the path, proven, in metres; `None` where it was not measured.
    pub clearance_m: Option<f64>,
    /// The grasp that the path ends at.
    pub grasp: Option<usize>,
    /// The score of that grasp, in [0, 1].
    pub grasp_score: Option<f64>,
    /// Whether the path also meets the other of the two criteria, where that was asked.
    pub also_solved: Option<bool>,
    /// Memory, in bytes: of a program of others with all that it started the most that it was seen to hold, looked at
    /// every 20 ms; of a built-in planner what its process held at the end of the search, the scenario and what earlier
    /// trials left allocated with it. `None` where nobody tells, and in older results.
    #[serde(default)]
    pub memory_bytes: Option<u64>,
}

impl TrialRecord {
    /// Of a trial without a path, or with one that is not judged yet.
    pub(crate) fn without_path(
        trial: &Trial,
        outcome: TrialOutcome,
        detail: Option<String>,
        statistics: Statistics,
    ) -> Self {
        Self {
            trial: trial.clone(),
            outcome,
            detail,
            statistics,
            path_length: None,
            clearance_m: None,
            grasp: None,
            grasp_score: None,
            also_solved: None,
            memory_bytes: None,
        }
    }

    /// Whether the judge found a path that meets the criterion.
    pub fn is_solved(&self) -> bool {
        self.outcome == TrialOutcome::Solved
    }
}
