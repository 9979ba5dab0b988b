use std::time::Duration;

use cranny_plan::{AuditSettings, Budget, Criterion, Goal, Outcome, PlanReport, Unobserved, search};

use crate::foreign_planner::{ForeignPlanner, ForeignTask};
use crate::opened_scenario::{OpenedScenario, OpenedScenarios};
use crate::process_group::Leash;
use crate::worker_message::{Message, Request, TrialAnswer};
use crate::{BenchError, PlannerCall, Trial, TrialOutcome, judge};

/// Runs one trial.
///
/// 1. Open the scenario, unless that was done before.
/// 2. Let the planner look for a path.
/// 3. Judge the path; under the other criterion too, where that is asked.
///
/// # Errors
/// [`BenchError`] where the question is wrong, so that there is no trial to run.
pub fn run(
    request: &Request,
    scenarios: &mut OpenedScenarios,
    leash: &Leash,
    tell: &mut dyn FnMut(&Message) -> Result<(), BenchError>,
) -> Result<TrialAnswer, BenchError> {
    let question = &request.question;
    let trial = &question.trial;
    // 1.
    let opened = scenarios.get(&question.source, trial.criterion)?;
    let goal = trial.goal.map(|index| goal_of(&opened, index)).transpose()?;
    let other = match trial.criterion {
        Criterion::Exact => Criterion::Paper,
        Criterion::Paper => Criterion::Exact,
    };
    let other = if question.judge_both { Some(scenarios.get(&question.source, other)?) } else { None };
    let foreign = match &question.call {
        PlannerCall::BuiltIn { .. } => None,
        _ => Some(ForeignPlanner::new(request, &opened)?),
    };
    tell(&Message::Opened)?;
    // 2.
    let answer = match (&question.call, &foreign) {
        (_, Some(foreign)) => {
            let task = ForeignTask { request, opened: &opened, goal: goal.as_deref() };
            foreign.plan(&task, leash)?
        }
        (PlannerCall::BuiltIn { planner, settings }, None) => {
            let planner = cranny_plan::planner_with(planner, settings)?;
            let budget = Budget {
                iterations: trial.iteration_limit.unwrap_or(u64::MAX),
                time: Duration::try_from_secs_f64(trial.time_limit_s).unwrap_or(Duration::MAX),
            };
            let mut problem = match goal {
                Some(goal) => opened.problem.with_goal(Goal::Configurations(vec![goal]))?,
                None => opened.problem.clone(),
            };
            of_report(search(planner.as_ref(), &mut problem, &budget, trial.seed, &mut Unobserved)?)
        }
        (_, None) => return Err(BenchError::Program { program: question.call.name() }),
    };
    tell(&Message::Planned)?;
    // 3.
    if answer.path.is_empty() {
        return Ok(given_up(answer, trial));
    }
    let settings = AuditSettings { clearances: question.measure_clearance, ..AuditSettings::default() };
    let mut answer = judge::judge(&opened.problem, answer, settings);
    if let (Some(other), false) = (other, answer.path.is_empty()) {
        answer.also_solved = judge::also_meets(&other.problem, &answer.path).ok();
    }
    let late_s = answer.statistics.planning_time_s - trial.time_limit_s;
    if answer.outcome == TrialOutcome::Solved && late_s > 0.0 {
        answer.outcome = TrialOutcome::BudgetExhausted;
        answer.detail = Some(format!("a path came {late_s:.3} s after the limit"));
    }
    Ok(answer)
}

fn goal_of(opened: &OpenedScenario, index: usize) -> Result<Vec<f64>, BenchError> {
    let goals = opened.goals()?;
    let missing =
        || BenchError::Goal { scenario: opened.scenario.id.clone(), goal: index, known: goals.len() };
    goals.get(index).cloned().ok_or_else(missing)
}

/// What a built-in planner says, not yet judged.
fn of_report(report: PlanReport) -> TrialAnswer {
    let outcome = match report.outcome {
        // Whether a path is one says the judge.
        Outcome::Solved | Outcome::BudgetExhausted => TrialOutcome::BudgetExhausted,
        Outcome::Cancelled => TrialOutcome::Cancelled,
        Outcome::GaveUp => TrialOutcome::GaveUp,
        Outcome::StartInvalid => TrialOutcome::StartInvalid,
        Outcome::GoalsInvalid => TrialOutcome::GoalsInvalid,
        Outcome::NoReachableGrasp => TrialOutcome::NoReachableGrasp,
    };
    TrialAnswer { path: report.path, ..TrialAnswer::without_path(outcome, None, report.statistics) }
}

/// A planner that stops at its limit may look at its clock so much before it, as a share of the limit.
const EARLY: f64 = 0.05;

/// Says of an answer without a path that its planner gave up, if it claims a budget that is not spent: it would else
/// count as one that might have found a path later.
fn given_up(answer: TrialAnswer, trial: &Trial) -> TrialAnswer {
    let time_s = answer.statistics.planning_time_s;
    let iterations = answer.statistics.iterations;
    // A program need not tell its iterations.
    let has_iterations_left = trial.iteration_limit.is_none_or(|limit| iterations > 0 && iterations < limit);
    let has_time_left = time_s < (1.0 - EARLY) * trial.time_limit_s;
    if answer.outcome != TrialOutcome::BudgetExhausted || !has_time_left || !has_iterations_left {
        return answer;
    }
    let detail = format!("it ended without a path after {time_s:.3} of {} s", trial.time_limit_s);
    TrialAnswer { outcome: TrialOutcome::GaveUp, detail: answer.detail.or(Some(detail)), ..answer }
}
