use cranny_plan::{Outcome, Statistics};
use cranny_task::Criterion;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray};

/// One run of one planner: the unit that is replayed and counted once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Id of the scenario.
    pub scenario: String,
    /// SHA-256 over the files of the scenario, in hexadecimal; it distinguishes scenarios of the same name.
    pub scenario_hash: String,
    /// Name of the planner in reports.
    pub planner: String,
    /// All its settings, as canonical JSON (sorted keys); they distinguish variants of one planner.
    pub settings: String,
    /// Criterion for a solved trial.
    pub criterion: Criterion,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Time limit, in seconds.
    pub time_limit_s: f64,
    /// Iteration limit; `None` if only time counts.
    pub iteration_limit: Option<u64>,
    /// Index of the one goal in the IK set of the scenario; `None` if the planner had all grasps.
    pub goal: Option<usize>,
}

impl Trial {
    /// Returns a text that identifies the trial uniquely.
    pub fn key(&self) -> String {
        serde_json::json!(self).to_string()
    }

    /// Returns true unless the planner is an external program, whose statements about its own search are not trusted.
    pub fn is_built_in(&self) -> bool {
        /// Keys that only external programs have among their settings ([`PlannerCall::settings`](crate::PlannerCall::settings)).
        #[derive(Deserialize)]
        // Other keys are settings of built-in planners.
        struct Program {
            exec: Option<serde::de::IgnoredAny>,
            released: Option<serde::de::IgnoredAny>,
        }
        let program = serde_json::from_str::<Program>(&self.settings);
        program.is_ok_and(|program| program.exec.is_none() && program.released.is_none())
    }
}

/// Outcome of a trial. The judge decides about "solved", not the planner.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, EnumString, IntoStaticStr, VariantArray,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum TrialOutcome {
    /// The planner returned a path, and the judge finds that it meets the criterion.
    Solved,
    /// The planner reached its time or iteration limit.
    BudgetExhausted,
    /// The planner ended without a path before its budget was spent.
    GaveUp,
    /// The search was stopped from outside.
    Cancelled,
    /// The start is in collision or outside the joint limits.
    StartInvalid,
    /// Every goal configuration is in collision or outside the joint limits.
    GoalsInvalid,
    /// The planner proved that no grasp can be reached.
    NoReachableGrasp,
    /// The planner returned a path, and the judge finds that it does not meet the criterion.
    Rejected,
    /// An optimiser of this package found a path that meets its own measure, and the proof refused it.
    ClaimedNotProven,
    /// The output of the planner is no path.
    Garbled,
    /// The planner's process ended by itself.
    Crashed,
    /// There is no verdict: the judge exceeded its limits of time or memory, or crashed, or the trial could not be started for lack
    /// of resources.
    Undecided,
    /// The planner exceeded its time limit and was stopped.
    Hung,
    /// The planner exceeded its memory limit.
    OutOfMemory,
    /// A signal ended the worker, from outside or from an external program.
    Killed,
}

impl TrialOutcome {
    /// Returns the outcome of a search for which the judge has found no valid path.
    pub(crate) fn without_path(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Solved | Outcome::BudgetExhausted => Self::BudgetExhausted,
            Outcome::Cancelled => Self::Cancelled,
            Outcome::GaveUp => Self::GaveUp,
            Outcome::StartInvalid => Self::StartInvalid,
            Outcome::GoalsInvalid => Self::GoalsInvalid,
            Outcome::ClaimedNotProven => Self::ClaimedNotProven,
            // No trial has a region as its goal.
            Outcome::NoReachableGrasp | Outcome::RegionOutOfReach => Self::NoReachableGrasp,
        }
    }

    /// Returns true for an outcome of a trial without a path that an external program can state, unless it spent its budget.
    pub(crate) fn is_stated_without_path(self) -> bool {
        matches!(self, Self::GaveUp | Self::NoReachableGrasp | Self::StartInvalid | Self::GoalsInvalid)
    }

    /// Returns the name in files and reports.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Maximum number of characters of [`TrialRecord::detail`]: a program chooses what it prints, and files can state anything.
pub const MOST_DETAIL: usize = 500;

/// Returns the first [`MOST_DETAIL`] characters of a detail.
pub(crate) fn short_detail(text: &str) -> String {
    match text.char_indices().nth(MOST_DETAIL) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// A trial with its result: one row of the results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialRecord {
    /// The trial.
    pub trial: Trial,
    /// Outcome of the trial.
    pub outcome: TrialOutcome,
    /// Details for the user: the first violation, the signal, or the first bad line; at most 500 characters.
    pub detail: Option<String>,
    /// Statistics of the search. For an external planner, `planning_time_s` is measured outside, and unreported values are 0.
    pub statistics: Statistics,
    /// Length of the path in the plain norm of `q` (m and rad alike); `None` unless solved.
    pub path_length: Option<f64>,
    /// Proven minimum clearance along the path, in metres; `None` if it was not measured.
    pub clearance_m: Option<f64>,
    /// Index of the grasp at the end of the path.
    pub grasp: Option<usize>,
    /// Score of that grasp, in [0, 1].
    pub grasp_score: Option<f64>,
    /// True if the path also meets the other criterion; `None` if this was not checked.
    pub also_solved: Option<bool>,
    /// Memory, in bytes. For an external program: peak of the program and its children, with the files in its scratch folder,
    /// sampled every 20 ms. For a built-in planner: growth of the resident set of its worker during the search (its peak less its size at the start), without the
    /// scenario; memory that earlier trials left to the worker and the search reuses does not count. `None` if unknown.
    #[serde(default)]
    pub memory_bytes: Option<u64>,
}

impl TrialRecord {
    /// Creates the record of a trial without a path, or with a path that is not judged yet.
    pub(crate) fn without_path(
        trial: &Trial,
        outcome: TrialOutcome,
        detail: Option<String>,
        statistics: Statistics,
    ) -> Self {
        Self {
            trial: trial.clone(),
            outcome,
            detail: detail.map(|text| short_detail(&text)),
            statistics,
            path_length: None,
            clearance_m: None,
            grasp: None,
            grasp_score: None,
            also_solved: None,
            memory_bytes: None,
        }
    }

    /// Returns true if the judge found that the path meets the criterion.
    pub fn is_solved(&self) -> bool {
        self.outcome == TrialOutcome::Solved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn details_are_short() {
        let long = "é".repeat(1_000_000);
        assert_eq!(short_detail(&long).chars().count(), MOST_DETAIL + 1);
        assert_eq!(short_detail("it ended"), "it ended");
    }
}
