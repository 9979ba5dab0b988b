use std::cmp::Ordering;

use cranny_file::shell_file;
use serde::Serialize;

use crate::report::row::Group;
use crate::{StoredTrial, TrialOutcome};

/// Trial to inspect, with the command that replays it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorstTrial {
    /// Number of the trial in the results.
    pub trial: u64,
    /// Name of the scenario, as in [`Row::scenario_name`](crate::report::Row).
    pub scenario_name: String,
    /// Name of the planner, as in [`Row::planner_name`](crate::report::Row).
    pub planner_name: String,
    /// Criterion for a solved trial.
    pub criterion: String,
    /// Index of the goal that it aimed at.
    pub goal: Option<usize>,
    /// Seed of the trial.
    pub seed: u64,
    /// Outcome of the trial.
    pub outcome: &'static str,
    /// Details for the user.
    pub detail: Option<String>,
    /// Planning time, in seconds.
    pub planning_time_s: f64,
    /// Number of iterations.
    pub iterations: u64,
    /// Command that replays it.
    pub replay: String,
}

/// Maximum number of failed trials, and of solved ones, whose paths can be inspected.
const MOST_OF_A_KIND: usize = 20;

/// Maximum number of failures of a group; in addition, its slowest solved trial is listed.
const MOST_FAILURES_OF_A_ROW: usize = 2;

/// Returns the trials of all groups, the worst first: unexpected failures, unsolved trials, then the slowest solved ones.
/// `results` is the name of the file.
pub fn worst_trials(groups: &[Group], results: &str) -> Vec<WorstTrial> {
    let of_kind = |is_solved: bool, most_of_a_row: usize| {
        let mut worst: Vec<(&StoredTrial, &Group)> = Vec::new();
        for group in groups {
            let of_kind = |run: &&StoredTrial| run.record.is_solved() == is_solved;
            let mut runs: Vec<&StoredTrial> = group.runs.iter().copied().filter(of_kind).collect();
            runs.sort_by(|a, b| worst_first(a, b));
            worst.extend(runs.into_iter().take(most_of_a_row).map(|run| (run, group)));
        }
        worst.sort_by(|(a, _), (b, _)| worst_first(a, b));
        worst.truncate(MOST_OF_A_KIND);
        worst
    };
    let worst = of_kind(false, MOST_FAILURES_OF_A_ROW).into_iter().chain(of_kind(true, 1));
    worst.map(|(run, group)| worst_trial(run, group, results)).collect()
}

fn worst_first(a: &StoredTrial, b: &StoredTrial) -> Ordering {
    badness(b).total_cmp(&badness(a)).then(a.id.cmp(&b.id))
}

/// Returns the rank by outcome, then by seconds: the difference between two outcomes exceeds any time limit.
fn badness(run: &StoredTrial) -> f64 {
    let record = &run.record;
    let kind = match record.outcome {
        TrialOutcome::Crashed => 11.0,
        TrialOutcome::Hung => 10.0,
        TrialOutcome::OutOfMemory => 9.0,
        TrialOutcome::Undecided => 8.5,
        TrialOutcome::Garbled => 8.0,
        TrialOutcome::Rejected => 7.0,
        TrialOutcome::ClaimedNotProven => 6.5,
        TrialOutcome::StartInvalid => 6.0,
        TrialOutcome::GoalsInvalid => 5.0,
        TrialOutcome::NoReachableGrasp => 4.0,
        TrialOutcome::GaveUp => 3.0,
        TrialOutcome::Cancelled | TrialOutcome::Killed => 2.0,
        TrialOutcome::BudgetExhausted => 1.0,
        TrialOutcome::Solved => 0.0,
    };
    kind * 1e9 + record.statistics.planning_time_s
}

fn worst_trial(run: &StoredTrial, group: &Group, results: &str) -> WorstTrial {
    let record = &run.record;
    WorstTrial {
        trial: run.id,
        scenario_name: group.row.scenario_name.clone(),
        planner_name: group.row.planner_name.clone(),
        criterion: group.row.criterion.clone(),
        goal: record.trial.goal,
        seed: record.trial.seed,
        outcome: record.outcome.name(),
        detail: record.detail.clone(),
        planning_time_s: record.statistics.planning_time_s,
        iterations: record.statistics.iterations,
        replay: format!("cranny bench replay {} {}", shell_file(results.as_ref()), run.id),
    }
}
