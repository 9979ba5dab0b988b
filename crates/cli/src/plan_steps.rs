use std::fmt::Write;
use std::path::Path;

use cranny_plan::{AuditSettings, Outcome};
use cranny_scenario::{PlanFile, Scenario, SequenceError, SequenceJudgement, SequencePlan, Step, StepDemand};
use cranny_solve::Request;
use serde::Serialize;

use crate::Answer;
use crate::arguments::{Output, PlanArguments, VerifyArguments};
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file;
use crate::plan_page;
use crate::plan_task::check_scenario;
use crate::progress::{SearchProgress, stop_on_interrupt};
use crate::statements::{Brought, statement_lines};
use crate::task::{Demand, Task};
use crate::text;

/// What `plan --steps --json` prints; the keys stay.
#[derive(Serialize)]
struct Planned<'a> {
    #[serde(flatten)]
    plans: &'a SequencePlan,
    solved: bool,
    plan_file: Option<&'a Path>,
}

/// Plans the steps of a scenario, and writes all of them to one file.
pub fn plan(
    arguments: &PlanArguments,
    request: &Request,
    file: &Path,
    output: Output,
) -> Result<Answer, Failure> {
    let Task { scenario, source, .. } = Task::open(&arguments.task, Demand::default(), output)?;
    if scenario.steps.is_empty() {
        let problem = format!("'{}' has no steps (`steps` in its scenario.yaml)", scenario.id);
        return Err(Failure::Flag { flag: "steps", problem });
    }
    let demand = StepDemand { robust: arguments.robust, all_pairs: arguments.task.strict_pairs };
    let mut progress = SearchProgress::new(output.quiet, stop_on_interrupt()?);
    let (plans, is_solved) = SequencePlan::solve(&scenario, (&source, demand), request, &mut progress)
        .map_err(|fault| match fault {
            SequenceError::Scenario(fault) => Failure::from(fault),
            SequenceError::Solve(fault) => Failure::from(fault),
        })?;
    progress.finish();
    let is_written = is_solved || arguments.output.is_some();
    if is_written {
        output_file::check(file, FileKind::Plan, output)?;
        plans.write(file)?;
    }
    let planned = Planned { plans: &plans, solved: is_solved, plan_file: is_written.then_some(file) };
    text::answer(&planned, || page(&planned, &scenario.steps), output)?;
    Ok(if is_solved { Answer::Done } else { Answer::No })
}

fn page(planned: &Planned, steps: &[Step]) -> String {
    let Planned { plans, solved, plan_file } = planned;
    let word = if *solved { "solved" } else { "NOT solved" };
    let count = plans.steps.iter().filter(|plan| plan.outcome == Outcome::Solved).count();
    let mut page = format!("{}: {word}, {count} of {} steps\n", plans.scenario, steps.len());
    for (index, (plan, Step { pick, .. })) in plans.steps.iter().zip(steps).enumerate() {
        let _ = writeln!(page, "  step {:<7}{}", index + 1, step(pick, plan));
        page.push_str(&causes(plan));
        for (name, pairs) in text::not_checked(&plan.not_checked) {
            let _ = writeln!(page, "  {name:<12}{pairs}");
        }
    }
    if let Some(duration_s) = plans.duration_s {
        let _ = writeln!(page, "  trajectory  {} over all steps", text::at_most_seconds(duration_s));
    }
    if let Some(file) = plan_file {
        let _ = writeln!(page, "  written to  {}", file.display());
    }
    page
}

/// Outcome of a step that picks an object.
fn step(object: &str, plan: &PlanFile) -> String {
    let place = plan.place.as_ref().map_or("", |place| &place.name);
    let took = text::seconds(plan.statistics.planning_time_s);
    let clearance = plan.clearance_m.map_or_else(String::new, |clearance_m| {
        format!(
            ", {} clear or more, proven{}",
            text::at_least_mm(clearance_m),
            text::but_for(&plan.not_checked)
        )
    });
    format!("{object} to '{place}': {} by {} in {took}{clearance}", plan.outcome.name(), plan.planner)
}

/// Why a step has no path.
fn causes(plan: &PlanFile) -> String {
    if plan.outcome == Outcome::Solved {
        return String::new();
    }
    let mut lines = format!("  cause       {}\n", plan.outcome.sentence());
    plan_page::blocked(plan, plan.grasps.as_deref() == Some("none"), &mut |name, value| {
        let _ = writeln!(lines, "  {name:<12}{value}");
    });
    lines
}

/// What `verify --json` prints of several steps; the keys stay.
#[derive(Serialize)]
struct Judged {
    #[serde(flatten)]
    brought: Brought,
    #[serde(flatten)]
    judgement: SequenceJudgement,
}

/// Judges the plans of a scenario's steps.
pub fn verify(
    plans: &SequencePlan,
    file: &Path,
    arguments: &VerifyArguments,
    output: Output,
) -> Result<Answer, Failure> {
    let demand = plans.steps.first().map(Demand::of_plan).unwrap_or_default();
    let demand = Demand { grasps: plans.given_grasps(), ..demand };
    let brought = Brought::of(&demand, arguments);
    let Task { scenario, source, .. } = Task::open(&arguments.task, demand, output)?;
    check_scenario(file, &plans.scenario, &scenario.id, "judged against")?;
    for plan in &plans.steps {
        plan.check_joints(file, &scenario.robot)?;
    }
    let settings = AuditSettings { at_goal: !arguments.any_end, ..AuditSettings::default() };
    let demand = StepDemand { all_pairs: arguments.task.strict_pairs, ..StepDemand::default() };
    let problem_of = |of_step: &Scenario, plan: &PlanFile| {
        Ok(demand.checked(of_step.problem(arguments.task.margins.or(plan.margins))?))
    };
    let judgement = plans.judge((&scenario, &source), problem_of, settings)?;
    let judged = Judged { brought, judgement };
    text::answer(&judged, || page_of_verdict(&judged, scenario.steps.len()), output)?;
    Ok(if judged.judgement.valid { Answer::Done } else { Answer::No })
}

fn page_of_verdict(judged: &Judged, count: usize) -> String {
    let Judged { brought, judgement: SequenceJudgement { valid, violations, steps, differs } } = judged;
    let word = if *valid { "valid" } else { "NOT valid" };
    let not_checked: Vec<_> = steps.iter().flat_map(|step| step.audit.not_checked.iter().cloned()).collect();
    let but_for = text::but_for(&not_checked);
    let mut page = format!("{word}{but_for}: {} of {count} steps judged\n{}", steps.len(), brought.lines());
    for violation in violations {
        let _ = writeln!(page, "  {:<12}{violation}", violation.kind());
    }
    for statement in differs {
        let _ = writeln!(page, "  differs     {statement}");
    }
    for (index, judgement) in steps.iter().enumerate() {
        let clearance = judgement.audit.clearance_m.map_or_else(String::new, text::at_least_mm);
        let limited_by =
            text::limited_by(judgement.audit.clearance_limit.as_ref(), judgement.demanded.margins);
        let step = index + 1;
        let _ =
            writeln!(page, "  step {step:<7}clearance {clearance} or more along the whole path{limited_by}");
        for violation in &judgement.audit.violations {
            let _ = writeln!(page, "  {:<12}{violation}", violation.kind());
        }
        for (name, pairs) in text::not_checked(&judgement.audit.not_checked) {
            let _ = writeln!(page, "  {name:<12}{pairs}");
        }
        page.push_str(&statement_lines(judgement));
    }
    page
}
