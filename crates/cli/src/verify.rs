use std::fmt::Write as _;

use cranny_plan::{Verification, ViolationKind};
use cranny_scenario::{PlanFile, read_waypoints};

use crate::Answer;
use crate::arguments::{Output, VerifyArguments};
use crate::failure::Failure;
use crate::plan_task::PlanTask;
use crate::text::{self, degrees, millimetres};

pub fn run(arguments: &VerifyArguments, output: Output) -> Result<Answer, Failure> {
    let file = arguments.plan();
    let is_plan = file.extension().is_some_and(|extension| extension == "json");
    let plan = if is_plan { Some(PlanFile::read(file)?) } else { None };
    let criterion = plan.as_ref().map(|plan| plan.criterion);
    let margins = plan.as_ref().map(|plan| plan.margins).unwrap_or_default();
    let PlanTask { id, problem, .. } =
        PlanTask::open(&arguments.task, &arguments.moveit, criterion, margins, output)?;
    if let Some(plan) = &plan {
        let (found, expected) = (&plan.joint_names, problem.robot.joint_names());
        if let Some((found, expected)) =
            found.iter().zip(expected).find(|(found, expected)| found != expected)
        {
            return Err(Failure::OtherRobot {
                path: file.to_owned(),
                found: found.clone(),
                expected: expected.clone(),
            });
        }
        if plan.scenario != id {
            text::note(&format!(
                "the plan was made for scenario '{}', and is judged against '{id}'",
                plan.scenario
            ))?;
        }
    }
    // A pipe can be read once only.
    let path = match plan {
        Some(plan) => plan.into_waypoints(file, problem.robot.dof())?,
        None => read_waypoints(file, problem.robot.dof())?,
    };
    let verification = cranny_plan::verify(&problem, &path)?;
    if output.json {
        text::print_json(&verification)?;
    } else if !output.quiet {
        text::print(&page(&verification, path.len()))?;
    }
    Ok(if verification.valid { Answer::Done } else { Answer::No })
}

/// More lines nobody reads.
const MOST_SHOWN: usize = 1000;

fn page(verification: &Verification, way_points: usize) -> String {
    let word = if verification.valid { "valid" } else { "NOT valid" };
    let but_for = text::but_for(&verification.not_checked);
    let mut page = format!("{word}{but_for}: {way_points} way points\n");
    for violation in verification.violations.iter().take(MOST_SHOWN) {
        let place = format!("edge {} at {:.3}", violation.edge, violation.at);
        let _ = match violation.kind {
            ViolationKind::Contact if violation.second.is_empty() => {
                writeln!(page, "  contact     way point {}", violation.edge)
            }
            ViolationKind::Contact => writeln!(
                page,
                "  contact     {place}: {} is {} deep in {}",
                violation.first,
                millimetres(violation.depth_m),
                violation.second
            ),
            ViolationKind::Clearance => writeln!(
                page,
                "  clearance   {place}: {} comes too close to {}",
                violation.first, violation.second
            ),
            ViolationKind::Unresolved => writeln!(
                page,
                "  unresolved  {place}: {} against {} can be neither proven nor refuted",
                violation.first, violation.second
            ),
            ViolationKind::JointLimit => writeln!(
                page,
                "  limit       way point {}: {} is {:.4} beyond its limit",
                violation.edge, violation.first, violation.depth_m
            ),
            ViolationKind::Step => {
                writeln!(
                    page,
                    "  step        edge {}: longer than the released planners step",
                    violation.edge
                )
            }
            ViolationKind::Start => writeln!(
                page,
                "  start       {} is {:.6} off the start of the scenario",
                violation.first, violation.depth_m
            ),
            _ => writeln!(page, "  goal        the path does not end at a goal"),
        };
    }
    if let Some(more) = verification.violations.len().checked_sub(MOST_SHOWN).filter(|more| *more > 0) {
        let _ = writeln!(page, "  …           {more} more; --json lists them all");
    }
    if let Some(goal) = &verification.goal {
        let (translation, rotation) = (goal.translation_error_m, goal.rotation_error_rad);
        let _ = writeln!(
            page,
            "  goal        grasp {}: {}, {} off",
            goal.grasp,
            millimetres(translation),
            degrees(rotation)
        );
    }
    for pair in &verification.not_checked {
        let _ = writeln!(page, "  not checked {}", text::not_checked(pair));
    }
    if let Some(clearance) = verification.clearance_m {
        let _ = writeln!(page, "  clearance   {} or more along the whole path", millimetres(clearance));
    }
    page
}
