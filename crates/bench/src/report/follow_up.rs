//! How far a trial was followed: what its record says about the time and the iterations that it takes.
//!
//! A planner that was stopped might have found a path later: its trial is censored where it was stopped. One
//! that gave up, crashed or answered wrongly would not have been right later: its trial stays unsolved up to
//! the limit. Counted so, the curve at time `t` is the share of all trials that were solved by `t`, and a
//! planner gains nothing by giving up early.

use crate::statistics::Followed;
use crate::{TrialOutcome, TrialRecord};

/// In seconds.
pub fn over_time(record: &TrialRecord) -> Followed {
    let (limit_s, time_s) = (record.trial.time_limit_s, record.statistics.planning_time_s);
    if record.is_solved() {
        Followed { until: time_s, solved: true }
    } else if is_stopped_early(record) {
        Followed { until: time_s.min(limit_s), solved: false }
    } else {
        Followed { until: limit_s, solved: false }
    }
}

/// In iterations; `most` is how far the longest trial of the same planner went.
pub fn over_iterations(record: &TrialRecord, most: u64) -> Followed {
    let done = record.statistics.iterations;
    let is_stopped = matches!(record.outcome, TrialOutcome::BudgetExhausted | TrialOutcome::Cancelled);
    let until = if record.is_solved() || is_stopped { done } else { most };
    Followed { until: until as f64, solved: record.is_solved() }
}

/// The time as the paper counts it: a failure takes the limit.
pub fn paper_time_s(record: &TrialRecord) -> f64 {
    if record.is_solved() { record.statistics.planning_time_s } else { record.trial.time_limit_s }
}

/// Whether the trial was stopped from outside before its time was up.
fn is_stopped_early(record: &TrialRecord) -> bool {
    let is_done = || record.trial.iteration_limit.is_some_and(|limit| record.statistics.iterations >= limit);
    match record.outcome {
        TrialOutcome::Cancelled | TrialOutcome::Killed => true,
        TrialOutcome::BudgetExhausted => is_done(),
        TrialOutcome::Solved
        | TrialOutcome::GaveUp
        | TrialOutcome::StartInvalid
        | TrialOutcome::GoalsInvalid
        | TrialOutcome::NoReachableGrasp
        | TrialOutcome::Rejected
        | TrialOutcome::Garbled
        | TrialOutcome::Crashed
        | TrialOutcome::Hung
        | TrialOutcome::OutOfMemory => false,
    }
}
