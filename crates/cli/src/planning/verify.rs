use std::fmt::Write as _;
use std::path::Path;

use cranny_file::counted;
use cranny_path::{Audit, AuditSettings, audit_with};
use cranny_plan::PlanError;
use cranny_record::{Judgement, read_waypoints};
use cranny_task::Criterion;
use serde::Serialize;

use crate::Answer;
use crate::arguments::{Output, VerifyArguments};
use crate::failure::Failure;
use crate::planning::plan_task::{PlanTask, check_plan, read_plan};
use crate::planning::task::Demand;
use crate::statements::{Brought, statement_lines};
use crate::text::{self, at_most_degrees, at_most_mm};

pub fn run(arguments: &VerifyArguments, output: Output) -> Result<Answer, Failure> {
    let file = arguments.plan();
    let plan = read_plan(file)?;
    let demand = plan.as_ref().map(Demand::of_plan).unwrap_or_default();
    let brought = Brought::of(&demand, arguments);
    let PlanTask { source, problem, deviations, scenario, .. } =
        PlanTask::open(&arguments.task, &arguments.moveit, demand, output)?;
    let settings = AuditSettings { at_goal: !arguments.any_end, ..AuditSettings::default() };
    let (judged, way_points) = if let Some(plan) = &plan {
        check_plan(file, plan, problem.robot(), &source.scenario, "judged against")?;
        plan.check_path(file, problem.robot().dof())?;
        let source = scenario.as_ref().map_or_else(|| source.clone(), |known| plan.source_in(known, &source));
        let judgement = plan.judge(&source, &problem, settings).map_err(|fault| in_plan(file, fault))?;
        let judgement = judgement.ok_or(cranny_path::PathError::EmptyPath)?;
        (Judged::Plan(Box::new(judgement)), plan.waypoints.len())
    } else {
        let path = read_waypoints(file, problem.robot().dof())?;
        (Judged::Path(Box::new(audit_with(&problem, &path, settings)?)), path.len())
    };
    let audit = judged.audit();
    let limited_by = text::limited_by(audit.clearance_limit.as_ref(), source.margins);
    let answered = Answered { criterion: problem.criterion(), brought, deviations, judged };
    text::answer(&answered, || page(&answered, way_points, &limited_by), output)?;
    Ok(if answered.judged.audit().valid { Answer::Done } else { Answer::No })
}

/// Names the plan file, which has the stages that do not fit the problem.
fn in_plan(file: &Path, fault: PlanError) -> Failure {
    match fault {
        PlanError::Task(fault) => Failure::File { path: file.to_owned(), problem: fault.to_string() },
        fault => fault.into(),
    }
}

/// Maximum number of violations printed.
const MOST_SHOWN: usize = 1000;

/// Output of `verify --json`; its keys are stable.
#[derive(Serialize)]
struct Answered {
    criterion: Criterion,
    #[serde(flatten)]
    brought: Brought,
    /// Deviations of the problem from its files, in sentences.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    deviations: Vec<String>,
    #[serde(flatten)]
    judged: Judged,
}

/// Verdict on a plan file, or on bare way points.
#[derive(Serialize)]
#[serde(untagged)]
enum Judged {
    Plan(Box<Judgement>),
    Path(Box<Audit>),
}

impl Judged {
    fn audit(&self) -> &Audit {
        match self {
            Self::Plan(judgement) => &judgement.audit,
            Self::Path(audit) => audit,
        }
    }
}

fn page(answered: &Answered, way_points: usize, limited_by: &str) -> String {
    let Answered { criterion, brought, deviations, judged } = answered;
    let audit = judged.audit();
    let word = if audit.valid { "valid" } else { "NOT valid" };
    let by = if *criterion == Criterion::Paper {
        " under the paper's criterion, which proves nothing"
    } else {
        ""
    };
    let but_for = text::but_for(&audit.not_checked);
    let mut page = format!("{word}{by}{but_for}: {}\n", counted(way_points, "way point"));
    page.push_str(&brought.lines());
    for violation in audit.violations.iter().take(MOST_SHOWN) {
        let _ = writeln!(page, "  {:<11} {violation}", violation.kind());
    }
    if let Some(more) = audit.violations.len().checked_sub(MOST_SHOWN).filter(|more| *more > 0) {
        let _ = writeln!(page, "  …           {more} more; --json lists them all");
    }
    // A missed goal is already among the violations.
    let is_told = audit.violations.iter().any(|violation| violation.kind() == "goal");
    if let Some(goal) = audit.goal.as_ref().filter(|_| !is_told) {
        let (translation, rotation) = (goal.translation_error_m, goal.rotation_error_rad);
        let _ = writeln!(
            page,
            "  goal        grasp {}: {}, {} off",
            goal.grasp,
            at_most_mm(translation),
            at_most_degrees(rotation)
        );
    }
    if let Some(grasp) = &audit.own_grasp {
        let _ = writeln!(page, "  goal        {}", text::own_grasp(grasp));
    }
    for deviation in deviations {
        let _ = writeln!(page, "  note        {deviation}");
    }
    for (name, pairs) in text::not_checked(&audit.not_checked) {
        let _ = writeln!(page, "  {name:<12}{pairs}");
    }
    if let Some(clearance) = audit.clearance_m.filter(|clearance_m| audit.valid || *clearance_m > 0.0) {
        let clearance = text::at_least_mm(clearance);
        let _ = writeln!(page, "  clearance   {clearance} or more along the whole path{limited_by}");
    }
    if let Judged::Plan(judgement) = judged {
        page.push_str(&statement_lines(judgement));
    }
    page
}
