use std::fmt::Write as _;

use cranny_plan::{Audit, AuditSettings, audit_with};
use cranny_scenario::read_waypoints;

use crate::Answer;
use crate::arguments::{Output, VerifyArguments};
use crate::failure::Failure;
use crate::plan_task::{PlanTask, check_plan, read_plan};
use crate::text::{self, degrees, millimetres};

pub fn run(arguments: &VerifyArguments, output: Output) -> Result<Answer, Failure> {
    let file = arguments.plan();
    let plan = read_plan(file)?;
    let criterion = plan.as_ref().map(|plan| plan.criterion);
    let margins = plan.as_ref().map(|plan| plan.margins).unwrap_or_default();
    let PlanTask { source, problem, .. } =
        PlanTask::open(&arguments.task, &arguments.moveit, criterion, margins, output)?;
    if let Some(plan) = &plan {
        check_plan(file, plan, problem.robot(), &source.scenario, "judged against")?;
    }
    let settings = AuditSettings { at_goal: !arguments.any_end, ..AuditSettings::default() };
    let carried = plan.as_ref().filter(|plan| plan.segments.len() > 1).cloned();
    // A pipe can be read once only.
    let path = match plan {
        Some(plan) => plan.into_waypoints(file, problem.robot().dof())?,
        None => read_waypoints(file, problem.robot().dof())?,
    };
    let audit = match carried.map(|plan| plan.audit(&problem, settings)).transpose()?.flatten() {
        Some(audit) => audit,
        None => audit_with(&problem, &path, settings)?,
    };
    text::answer(&audit, || page(&audit, path.len()), output)?;
    Ok(if audit.valid { Answer::Done } else { Answer::No })
}

/// More lines nobody reads.
const MOST_SHOWN: usize = 1000;

fn page(audit: &Audit, way_points: usize) -> String {
    let word = if audit.valid { "valid" } else { "NOT valid" };
    let but_for = text::but_for(&audit.not_checked);
    let mut page = format!("{word}{but_for}: {way_points} way points\n");
    for violation in audit.violations.iter().take(MOST_SHOWN) {
        let _ = writeln!(page, "  {:<12}{violation}", violation.kind());
    }
    if let Some(more) = audit.violations.len().checked_sub(MOST_SHOWN).filter(|more| *more > 0) {
        let _ = writeln!(page, "  …           {more} more; --json lists them all");
    }
    if let Some(goal) = &audit.goal {
        let (translation, rotation) = (goal.translation_error_m, goal.rotation_error_rad);
        let _ = writeln!(
            page,
            "  goal        grasp {}: {}, {} off",
            goal.grasp,
            millimetres(translation),
            degrees(rotation)
        );
    }
    for pair in &audit.not_checked {
        let _ = writeln!(page, "  not checked {}", text::not_checked(pair));
    }
    if let Some(clearance) = audit.clearance_m {
        let _ = writeln!(page, "  clearance   {} or more along the whole path", millimetres(clearance));
    }
    page
}
