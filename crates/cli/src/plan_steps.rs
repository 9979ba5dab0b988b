use std::fmt::Write;
use std::path::Path;

use cranny_plan::{Audit, AuditSettings};
use cranny_scenario::{PlanFile, PlanSource, SequenceError, SequencePlan};
use cranny_solve::Request;
use serde::Serialize;

use crate::Answer;
use crate::arguments::{Output, PlanArguments, VerifyArguments};
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file;
use crate::progress::{SearchProgress, stop_on_interrupt};
use crate::task::{Demand, Task};
use crate::text::{self, millimetres};

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
    let Task { scenario, margins, .. } = Task::open(&arguments.task, Demand::default(), output)?;
    if scenario.steps.is_empty() {
        let problem = format!("'{}' has no steps (`steps` in its scenario.yaml)", scenario.id);
        return Err(Failure::Flag { flag: "steps", problem });
    }
    let source = PlanSource {
        scenario: scenario.id.clone(),
        robot: arguments.task.robot.clone(),
        geometry: arguments.task.geometry.map(Into::into),
        margins,
        ..PlanSource::default()
    };
    let mut progress = SearchProgress::new(output.quiet, stop_on_interrupt()?);
    let (plans, is_solved) =
        SequencePlan::solve(&scenario, &source, request, &mut progress).map_err(|fault| match fault {
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
    text::answer(&planned, || page(&planned, scenario.steps.len()), output)?;
    Ok(if is_solved { Answer::Done } else { Answer::No })
}

fn page(planned: &Planned, count: usize) -> String {
    let Planned { plans, solved, plan_file } = planned;
    let word = if *solved { "solved" } else { "NOT solved" };
    let mut page = format!("{}: {word}, {} of {count} steps\n", plans.scenario, plans.steps.len());
    for (index, plan) in plans.steps.iter().enumerate() {
        let _ = writeln!(page, "  step {:<7}{}", index + 1, step(plan));
        for pair in &plan.not_checked {
            let _ = writeln!(page, "  {:<12}{}", text::exemption(pair), text::not_checked(pair));
        }
    }
    if let Some(duration_s) = plans.duration_s {
        let _ = writeln!(page, "  trajectory  {duration_s:.3} s over all steps");
    }
    if let Some(file) = plan_file {
        let _ = writeln!(page, "  written to  {}", file.display());
    }
    page
}

/// What came of a step.
fn step(plan: &PlanFile) -> String {
    let object = plan.segments.iter().find_map(|segment| segment.attached.as_deref()).unwrap_or("nothing");
    let place = plan.place.as_ref().map_or("", |place| &place.name);
    let took = text::seconds(plan.statistics.planning_time_s);
    let clearance = plan.clearance_m.map_or_else(String::new, |clearance_m| {
        format!(", {} clear or more, proven{}", millimetres(clearance_m), text::but_for(&plan.not_checked))
    });
    format!("{object} to '{place}': {} by {} in {took}{clearance}", plan.outcome.name(), plan.planner)
}

/// What `verify --json` prints of several steps; the keys stay.
#[derive(Serialize)]
struct Judged<'a> {
    valid: bool,
    steps: &'a [Audit],
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
    let Task { scenario, margins, .. } = Task::open(&arguments.task, demand, output)?;
    if plans.scenario != scenario.id {
        let planned = &plans.scenario;
        text::note(&format!(
            "the plan was made for scenario '{planned}', and is judged against '{}'",
            scenario.id
        ))?;
    }
    for plan in &plans.steps {
        plan.check_joints(file, &scenario.robot)?;
    }
    let settings = AuditSettings { at_goal: !arguments.any_end, ..AuditSettings::default() };
    let audits = plans.audit(&scenario, margins, settings)?;
    let judged = Judged { valid: plans.is_solved(&scenario, &audits), steps: &audits };
    text::answer(&judged, || judgement(&judged, scenario.steps.len()), output)?;
    Ok(if judged.valid { Answer::Done } else { Answer::No })
}

fn judgement(judged: &Judged, count: usize) -> String {
    let word = if judged.valid { "valid" } else { "NOT valid" };
    let mut page = format!("{word}: {} of {count} steps judged\n", judged.steps.len());
    for (index, audit) in judged.steps.iter().enumerate() {
        let clearance = audit.clearance_m.map_or_else(String::new, millimetres);
        let _ = writeln!(page, "  step {:<7}clearance {clearance} or more along the whole path", index + 1);
        for violation in &audit.violations {
            let _ = writeln!(page, "  {:<12}{violation}", violation.kind());
        }
        for pair in &audit.not_checked {
            let _ = writeln!(page, "  {:<12}{}", text::exemption(pair), text::not_checked(pair));
        }
    }
    page
}
