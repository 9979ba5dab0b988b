use std::time::Duration;

use cranny_plan::{Budget, ClearanceReport, Criterion, Outcome, PlanReport, Unobserved, search};

use crate::foreign_planner::{ForeignPlanner, ForeignTask};
use crate::opened_scenario::{OpenedScenario, OpenedScenarios};
use crate::process_group::Leash;
use crate::worker_message::{Message, Request, TrialAnswer};
use crate::{BenchError, PlannerCall, TrialOutcome, judge};

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
                Some(goal) => opened.problem.with_goal(goal)?,
                None => opened.problem.clone(),
            };
            of_report(search(planner.as_ref(), &mut problem, &budget, trial.seed, &mut Unobserved)?)
        }
        (_, None) => return Err(BenchError::Program { program: question.call.name() }),
    };
    tell(&Message::Planned)?;
    // 3.
    if answer.path.is_empty() {
        return Ok(answer);
    }
    let report = if question.measure_clearance { ClearanceReport::PerEdge } else { ClearanceReport::Left };
    let mut answer = judge::judge(&opened.problem, answer, report);
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
        Outcome::StartInvalid => TrialOutcome::StartInvalid,
        Outcome::NoReachableGrasp => TrialOutcome::NoReachableGrasp,
        _ => TrialOutcome::BudgetExhausted,
    };
    TrialAnswer { path: report.path, ..TrialAnswer::without_path(outcome, None, report.statistics) }
}
