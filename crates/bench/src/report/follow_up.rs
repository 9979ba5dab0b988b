//! Follow-up of a trial, for its time and its iterations.
//!
//! A built-in planner that its iteration limit stopped might have found a path later: its trial is censored at that point. Every
//! other trial without a path stays unsolved up to the limit, also if its planner gave up, crashed, answered wrongly or was lost
//! with its worker: no statement of an external program about its search is trusted, and it may kill its worker. The curve at
//! time `t` is then the share of all trials solved by `t`, and a planner gains nothing by ending early.

use crate::statistics::Followed;
use crate::{TrialOutcome, TrialRecord};

/// Returns the follow-up in seconds.
pub fn over_time(record: &TrialRecord) -> Followed {
    let (limit_s, time_s) = (record.trial.time_limit_s, record.statistics.planning_time_s);
    if record.is_solved() {
        Followed { until: time_s, solved: true }
    } else if is_ended_by_iterations(record) {
        Followed { until: time_s.min(limit_s), solved: false }
    } else {
        Followed { until: limit_s, solved: false }
    }
}

/// Returns the follow-up in iterations; `most` is the maximum over the trials of the same planner.
pub fn over_iterations(record: &TrialRecord, most: u64) -> Followed {
    let is_stopped = is_spent(record) && record.trial.is_built_in();
    let until = if record.is_solved() || is_stopped { record.statistics.iterations } else { most };
    Followed { until: until as f64, solved: record.is_solved() }
}

/// Cuts off the follow-up when half of the trials are censored: the curve would depend only on the few that continue.
pub fn while_half_are_followed(trials: Vec<Followed>) -> Vec<Followed> {
    let mut cut: Vec<f64> = trials.iter().filter(|trial| !trial.solved).map(|trial| trial.until).collect();
    cut.sort_by(f64::total_cmp);
    match cut.get(trials.len() / 2) {
        Some(&end) => trials.into_iter().map(|trial| trial.up_to(end)).collect(),
        None => trials,
    }
}

/// Returns the time as in the paper, in seconds: a failure counts with its limit.
pub fn paper_time_s(record: &TrialRecord) -> f64 {
    if record.is_solved() { record.statistics.planning_time_s } else { record.trial.time_limit_s }
}

/// Returns true if the budget ended the search, with or without a path that the proof refused.
fn is_spent(record: &TrialRecord) -> bool {
    matches!(record.outcome, TrialOutcome::BudgetExhausted | TrialOutcome::ClaimedNotProven)
}

/// Returns true if the iteration limit ended the search of a built-in planner, whose iterations are counted.
fn is_ended_by_iterations(record: &TrialRecord) -> bool {
    let is_done = |limit| record.statistics.iterations >= limit;
    is_spent(record) && record.trial.iteration_limit.is_some_and(is_done) && record.trial.is_built_in()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_long_trials_do_not_speak_for_all() {
        let trial = |until: f64, solved| Followed { until, solved };
        let mut trials = vec![trial(10.0, true), trial(20.0, false), trial(30.0, false), trial(40.0, false)];
        trials.push(trial(50.0, true));
        let followed = while_half_are_followed(trials.clone());
        let expected = [
            trial(10.0, true),
            trial(20.0, false),
            trial(30.0, false),
            trial(40.0, false),
            trial(40.0, false),
        ];
        assert_eq!(followed, expected, "the third of five is cut short at 40");
        trials[3].solved = true;
        assert_eq!(while_half_are_followed(trials.clone()), trials, "two of five are not half");
    }
}
