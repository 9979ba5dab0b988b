use std::fmt::Write as _;
use std::path::PathBuf;

use cranny_file::counted;
use cranny_plan::{Audit, AuditSettings, Criterion, audit_with};
use cranny_scenario::{GivenGrasps, PlanFile, SequencePlan, read_waypoints};
use serde::Serialize;

use crate::Answer;
use crate::arguments::{Output, VerifyArguments};
use crate::failure::Failure;
use crate::plan_steps;
use crate::plan_task::{PlanTask, check_plan, read_plan};
use crate::task::Demand;
use crate::text::{self, degrees, millimetres};

pub fn run(arguments: &VerifyArguments, output: Output) -> Result<Answer, Failure> {
    let file = arguments.plan();
    if let Some(plans) = SequencePlan::read(file)? {
        return plan_steps::verify(&plans, file, arguments, output);
    }
    let plan = read_plan(file)?;
    let demand = plan.as_ref().map(Demand::of_plan).unwrap_or_default();
    // What flags say goes before it.
    let brought = demand.clone();
    let robot = brought.robot.filter(|_| arguments.task.robot.is_none() && arguments.moveit.is_empty());
    let grasps = match brought.grasps {
        GivenGrasps::File(file) if arguments.task.grasps.is_none() && arguments.moveit.is_empty() => {
            Some(file)
        }
        _ => None,
    };
    let PlanTask { source, problem, .. } =
        PlanTask::open(&arguments.task, &arguments.moveit, demand, output)?;
    if let Some(plan) = &plan {
        check_plan(file, plan, problem.robot(), &source.scenario, "judged against")?;
    }
    let settings = AuditSettings { at_goal: !arguments.any_end, ..AuditSettings::default() };
    let says_more = |plan: &&PlanFile| plan.is_task() || plan.own_grasp.is_some();
    let telling = plan.as_ref().filter(says_more).cloned();
    // A pipe can be read once only.
    let path = match plan {
        Some(plan) => plan.into_waypoints(file, problem.robot().dof())?,
        None => read_waypoints(file, problem.robot().dof())?,
    };
    let audit = match telling.map(|plan| plan.audit(&problem, settings)).transpose()?.flatten() {
        Some(audit) => audit,
        None => audit_with(&problem, &path, settings)?,
    };
    let answered = Answered { criterion: problem.criterion(), robot, grasps, audit: &audit };
    text::answer(&answered, || page(&answered, path.len()), output)?;
    Ok(if audit.valid { Answer::Done } else { Answer::No })
}

/// More lines nobody reads.
const MOST_SHOWN: usize = 1000;

/// What `verify --json` prints; the keys stay.
#[derive(Serialize)]
struct Answered<'a> {
    criterion: Criterion,
    /// What the plan file brought along in place of the scenario's own, for which nobody but it vouches.
    #[serde(skip_serializing_if = "Option::is_none")]
    robot: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    grasps: Option<PathBuf>,
    #[serde(flatten)]
    audit: &'a Audit,
}

fn page(answered: &Answered, way_points: usize) -> String {
    let Answered { criterion, robot, grasps, audit } = answered;
    let word = if audit.valid { "valid" } else { "NOT valid" };
    let by = if *criterion == Criterion::Paper {
        " under the paper's criterion, which proves nothing"
    } else {
        ""
    };
    let but_for = text::but_for(&audit.not_checked);
    let mut page = format!("{word}{by}{but_for}: {}\n", counted(way_points, "way point"));
    for (what, file) in [("robot", robot), ("grasps", grasps)] {
        if let Some(file) = file {
            let _ = writeln!(page, "  {what:<12}{}, which the plan names", file.display());
        }
    }
    for violation in audit.violations.iter().take(MOST_SHOWN) {
        let _ = writeln!(page, "  {:<12}{violation}", violation.kind());
    }
    if let Some(more) = audit.violations.len().checked_sub(MOST_SHOWN).filter(|more| *more > 0) {
        let _ = writeln!(page, "  …           {more} more; --json lists them all");
    }
    // A path that misses its goal is told so above.
    let is_told = audit.violations.iter().any(|violation| violation.kind() == "goal");
    if let Some(goal) = audit.goal.as_ref().filter(|_| !is_told) {
        let (translation, rotation) = (goal.translation_error_m, goal.rotation_error_rad);
        let _ = writeln!(
            page,
            "  goal        grasp {}: {}, {} off",
            goal.grasp,
            millimetres(translation),
            degrees(rotation)
        );
    }
    if let Some(grasp) = &audit.own_grasp {
        let _ = writeln!(page, "  goal        {}", text::own_grasp(grasp));
    }
    for pairs in text::not_checked(&audit.not_checked) {
        let _ = writeln!(page, "  not checked {pairs}");
    }
    if let Some(clearance) = audit.clearance_m.filter(|clearance_m| audit.valid || *clearance_m > 0.0) {
        let _ = writeln!(page, "  clearance   {} or more along the whole path", millimetres(clearance));
    }
    page
}
