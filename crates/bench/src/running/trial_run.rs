use std::time::Duration;

use cranny_file::system::PeakMemory;
use cranny_path::{AuditSettings, Clearances, audit_task};
use cranny_plan::{Budget, Registry};
use cranny_solve::{DEFAULT_HOLD, Timing};
use cranny_task::{Criterion, Goal, Stage, joined};

use crate::asked::trial::short_detail;
use crate::foreign::foreign_planner::{ForeignPlanner, ForeignTask};
use crate::foreign::process_group::Leash;
use crate::running::built_in_search::{Found, Tell};
use crate::running::opened_scenario::{OpenedScenario, OpenedScenarios};
use crate::running::worker_message::{Message, Request, TrialRun};
use crate::{BenchError, PathDemand, PlannerCall, TrialOutcome, TrialRecord, running::judge};

/// Runs one trial, and returns its record and the planner's own path.
///
/// 1. Open the scenario, unless it is cached.
/// 2. Run the planner.
/// 3. Judge the path, also under the other criterion if required.
///
/// # Errors
/// [`BenchError`] if the question is invalid, so that there is no trial to run.
pub fn run(
    registry: &Registry,
    request: &Request,
    (scenarios, peak): (&mut OpenedScenarios, &mut PeakMemory),
    leash: &Leash,
    tell: Tell<'_>,
) -> Result<TrialRun, BenchError> {
    let question = &request.question;
    let trial = &question.trial;
    // 1.
    let opened = scenarios.get(trial, &question.source, trial.criterion)?;
    let goal = trial.goal.map(|index| goal_of(&opened, index)).transpose()?;
    let other = match trial.criterion {
        Criterion::Exact => Criterion::Paper,
        Criterion::Paper => Criterion::Exact,
    };
    let other = if question.judge_both { Some(scenarios.get(trial, &question.source, other)?) } else { None };
    let foreign = match &question.call {
        PlannerCall::BuiltIn { .. } => None,
        call => {
            call.check_unchanged(trial)?;
            Some(ForeignPlanner::new(request, &opened)?)
        }
    };
    if foreign.is_none() {
        tell(&Message::Opened)?;
    }
    // 2.
    let clearances = if question.measure_clearance { Clearances::OfPath } else { Clearances::None };
    let limits = judge::limits_for(&question.call);
    let settings = AuditSettings { clearances, limits, ..AuditSettings::default() };
    let demand = PathDemand::of_settings(&trial.settings);
    let stages = demand.stages_in(&opened.scenario)?;
    let (mut record, segments, audit) = match (&question.call, &foreign) {
        (_, Some(foreign)) => {
            let task = ForeignTask {
                request,
                opened: &opened,
                goal: goal.as_deref(),
                carry: demand.carry,
                stages: &stages,
            };
            let (record, segments) = foreign.plan(&task, leash, tell)?;
            (record, segments, None)
        }
        (PlannerCall::BuiltIn { planner, settings: planner_settings, score, min_score }, None) => {
            // A path to one goal is judged like a path to any grasp.
            let aimed =
                goal.map(|goal| opened.problem.with_goal(Goal::Configurations(vec![goal]))).transpose()?;
            let asked = cranny_solve::Request {
                registry: registry.clone(),
                planner: Some(planner.clone()),
                settings: planner_settings.clone(),
                score: Some(*score),
                min_score: *min_score,
                budget: Budget {
                    iterations: trial.iteration_limit.unwrap_or(u64::MAX),
                    time: Duration::try_from_secs_f64(trial.time_limit_s).unwrap_or(Duration::MAX),
                },
                seed: trial.seed,
                keep_path: true,
                stages: stages.clone(),
                hold: demand.hold.or(Some(DEFAULT_HOLD)),
                timing: demand.try_in_physics.map(|_| Timing::default()),
                // A path to one goal is judged below.
                audit: if aimed.is_some() {
                    AuditSettings { clearances: Clearances::None, ..settings }
                } else {
                    settings
                },
                ..cranny_solve::Request::default()
            };
            peak.begin();
            let problem = aimed.as_ref().unwrap_or(&opened.problem);
            let found = Found::plan((&opened.scenario, problem), &asked, &demand, (tell, peak))?;
            let record = found.record(trial);
            if found.failure.is_some() {
                // No plan went as planned: there is no path to judge.
                return Ok((record, Vec::new()));
            }
            (record, found.answer.segments, found.answer.audit.filter(|_| aimed.is_none()))
        }
        (_, None) => return Err(BenchError::Program { program: question.call.name() }),
    };
    // 3.
    let mut path = joined(&segments);
    if path.is_empty() {
        return Ok((given_up(record), path));
    }
    let judged = || {
        let own = Stage::of_goal(&opened.problem);
        let stages = if stages.is_empty() { &own } else { &stages };
        audit_task(&opened.problem, stages, &segments, settings)
    };
    let word = audit.map_or_else(judged, Ok);
    judge::decide(&mut record, &mut path, &opened.problem, word);
    let late_s = record.statistics.planning_time_s - trial.time_limit_s;
    if let (Some(other), Some(reach), false) = (other, segments.first(), path.is_empty() || late_s > 0.0) {
        record.also_solved = judge::also_meets(&other.problem, &reach.waypoints, limits).ok();
    }
    if record.is_solved() && late_s > 0.0 {
        record.outcome = TrialOutcome::BudgetExhausted;
        record.detail = Some(format!("a path came {late_s:.3} s after the limit"));
    }
    Ok((record, path))
}

fn goal_of(opened: &OpenedScenario, index: usize) -> Result<Vec<f64>, BenchError> {
    let goals = opened.goals()?;
    let missing =
        || BenchError::Goal { scenario: opened.scenario.id.clone(), goal: index, known: goals.len() };
    goals.get(index).cloned().ok_or_else(missing)
}

/// Tolerance of the time check: a planner may stop before its limit by this share of the limit.
const EARLY: f64 = 0.05;

/// Changes the outcome of a trial without a path to "gave up" if the planner ended before its budget was spent: it would
/// otherwise be censored, as if a path could have followed. The number of iterations that an external program states is not
/// trusted, and a campaign cancels no search. At its time limit the budget of a program is spent, whatever it states.
fn given_up(record: TrialRecord) -> TrialRecord {
    let TrialRecord { trial, outcome, statistics, .. } = &record;
    let time_s = statistics.planning_time_s;
    if !trial.is_built_in() && outcome.is_stated_without_path() && time_s >= trial.time_limit_s {
        return TrialRecord { outcome: TrialOutcome::BudgetExhausted, ..record };
    }
    let is_counted = |limit| trial.is_built_in() && statistics.iterations >= limit;
    let has_iterations_left = !trial.iteration_limit.is_some_and(is_counted);
    let has_time_left = time_s < (1.0 - EARLY) * trial.time_limit_s;
    let is_stopped = matches!(outcome, TrialOutcome::BudgetExhausted | TrialOutcome::Cancelled);
    if !is_stopped || !has_time_left || !has_iterations_left {
        return record;
    }
    let mut detail = format!("it ended without a path after {time_s:.3} of {} s", trial.time_limit_s);
    if let Some(own) = &record.detail {
        detail = short_detail(&format!("{detail}; {own}"));
    }
    TrialRecord { outcome: TrialOutcome::GaveUp, detail: Some(detail), ..record }
}

#[cfg(test)]
mod tests {
    use cranny_plan::Statistics;

    use super::*;
    use crate::Trial;

    /// Returns the outcome of a trial without a path after this time (s) of ten seconds and these iterations of a hundred.
    fn outcome(settings: &str, outcome: TrialOutcome, planning_time_s: f64, iterations: u64) -> TrialOutcome {
        let trial = Trial {
            scenario: "021".into(),
            scenario_hash: String::new(),
            planner: "x".into(),
            settings: settings.into(),
            criterion: Criterion::Exact,
            seed: 0,
            time_limit_s: 10.0,
            iteration_limit: Some(100),
            goal: None,
        };
        let statistics = Statistics { planning_time_s, iterations, ..Statistics::default() };
        given_up(TrialRecord::without_path(&trial, outcome, None, statistics)).outcome
    }

    #[test]
    fn no_program_is_believed_that_its_iterations_are_spent() {
        use TrialOutcome::{BudgetExhausted, Cancelled, GaveUp, NoReachableGrasp};
        let built_in = r#"{"planner":"reach"}"#;
        for program in [r#"{"exec":["sh","x"],"files":{}}"#, r#"{"files":{},"released":["y"]}"#, ""] {
            for iterations in [0, 5, 100, 1_000_000] {
                assert_eq!(outcome(program, BudgetExhausted, 0.02, iterations), GaveUp);
            }
            assert_eq!(outcome(program, BudgetExhausted, 9.9, 5), BudgetExhausted);
        }
        for stated in [NoReachableGrasp, TrialOutcome::StartInvalid, TrialOutcome::GoalsInvalid, GaveUp] {
            assert_eq!(outcome(r#"{"exec":["sh","x"]}"#, stated, 9.9, 0), stated);
            for time_s in [10.0, 10.3] {
                assert_eq!(outcome(r#"{"exec":["sh","x"]}"#, stated, time_s, 0), BudgetExhausted);
            }
        }
        let crashed = TrialOutcome::Crashed;
        assert_eq!(outcome(r#"{"exec":["sh","x"]}"#, crashed, 10.3, 0), crashed);
        assert_eq!(outcome(built_in, NoReachableGrasp, 10.3, 0), NoReachableGrasp);
        assert_eq!(outcome(built_in, BudgetExhausted, 0.02, 100), BudgetExhausted);
        assert_eq!(outcome(built_in, BudgetExhausted, 0.02, 99), GaveUp);
        assert_eq!(outcome(built_in, Cancelled, 0.02, 99), GaveUp);
        assert_eq!(outcome(built_in, NoReachableGrasp, 0.02, 100), NoReachableGrasp);
    }
}
