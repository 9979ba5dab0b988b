use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use cranny_plan::{Budget, Outcome, PlanReport, Planner, Problem, Validity, path_length, verify};
use cranny_scenario::{PlanBudget, PlanFile, PlanMargins, Scenario};
use serde::Serialize;

use crate::Answer;
use crate::arguments::{Output, PlanArguments};
use crate::failure::Failure;
use crate::progress::{SearchProgress, stop_on_interrupt};
use crate::start;
use crate::task::Task;
use crate::text::{self, degrees, millimetres};

/// What `plan --json` prints; the keys stay.
#[derive(Serialize)]
struct Answered<'a> {
    #[serde(flatten)]
    plan: &'a PlanFile,
    planning_time_s: f64,
    preparation_time_s: f64,
    iterations: u64,
    valid: bool,
    start_faults: Vec<String>,
    plan_file: Option<&'a Path>,
}

pub fn run(arguments: &PlanArguments, output: Output) -> Result<Answer, Failure> {
    let named = arguments.planner.as_deref().map(cranny_plan::planner).transpose()?;
    let begin = Instant::now();
    let Task { scenario, mut problem, margins } = Task::open(&arguments.task, None, PlanMargins::default())?;
    let preparation_time_s = begin.elapsed().as_secs_f64();
    let file = destination(arguments, &scenario)?;
    set_threshold(arguments, &mut problem)?;
    let planner = named.unwrap_or_else(|| cranny_plan::default_planner(problem.criterion()));
    let budget = Budget { iterations: arguments.iterations.unwrap_or(u64::MAX), time: arguments.time_limit };

    let mut progress = SearchProgress::new(output.quiet, stop_on_interrupt()?);
    let report = planner.plan(&problem, &budget, arguments.seed, &mut progress)?;
    progress.finish();

    let judged = judge(arguments, &scenario, &problem, margins, planner.as_ref(), &report)?;
    let solved = report.outcome == Outcome::Solved && judged.valid;
    if solved {
        judged.plan.write(&file)?;
    }
    let answered = Answered {
        planning_time_s: report.statistics.planning_time_s,
        preparation_time_s,
        iterations: report.statistics.iterations,
        valid: judged.valid,
        start_faults: start::faults(&problem),
        plan_file: solved.then_some(file.as_path()),
        plan: &judged.plan,
    };
    if output.json {
        text::print_json(&answered)?;
    } else if !output.quiet {
        text::print(&page(&answered, &scenario))?;
    }
    Ok(if solved { Answer::Done } else { Answer::No })
}

struct Judged {
    plan: PlanFile,
    valid: bool,
}

/// Every answer is judged like anybody's before it is called solved.
fn judge(
    arguments: &PlanArguments,
    scenario: &Scenario,
    problem: &Problem,
    margins: PlanMargins,
    planner: &dyn Planner,
    report: &PlanReport,
) -> Result<Judged, Failure> {
    let verification = if report.path.is_empty() { None } else { Some(verify(problem, &report.path)?) };
    let goal = verification.as_ref().and_then(|v| v.goal);
    let plan = PlanFile {
        scenario: scenario.id.clone(),
        robot: arguments.task.robot.as_ref().map(|file| file.display().to_string()),
        geometry: arguments.task.geometry.map(|geometry| geometry.name().to_owned()),
        planner: planner.name().to_owned(),
        settings: planner.settings(),
        goal_threshold: match &problem.validity {
            Validity::Paper { threshold, .. } => Some(*threshold),
            Validity::Exact(_) => None,
        },
        criterion: problem.criterion(),
        seed: arguments.seed,
        version: PlanFile::VERSION.to_owned(),
        outcome: report.outcome,
        margins,
        budget: PlanBudget {
            iterations: arguments.iterations,
            time_limit_s: Some(arguments.time_limit.as_secs_f64()),
        },
        joint_names: problem.robot.joint_names().to_vec(),
        grasp: goal.map(|g| g.grasp),
        translation_error_m: goal.map(|g| g.translation_error_m),
        rotation_error_rad: goal.map(|g| g.rotation_error_rad),
        clearance_m: verification.as_ref().and_then(|v| v.clearance_m),
        clearances_per_edge_m: verification
            .as_ref()
            .map(|v| v.clearances_per_edge_m.clone())
            .unwrap_or_default(),
        path_length: path_length(&report.path),
        waypoints: report.path.clone(),
        statistics: report.statistics,
    };
    Ok(Judged { plan, valid: verification.is_some_and(|v| v.valid) })
}

fn destination(arguments: &PlanArguments, scenario: &Scenario) -> Result<PathBuf, Failure> {
    let file =
        arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.plan.json", scenario.id)));
    if file.parent().is_some_and(|folder| !folder.as_os_str().is_empty() && !folder.is_dir()) {
        return Err(Failure::NoFolder { path: file });
    }
    // Better now than after the search.
    PlanFile::check_writable(&file)?;
    Ok(file)
}

fn set_threshold(arguments: &PlanArguments, problem: &mut Problem) -> Result<(), Failure> {
    let is_default = (arguments.goal_threshold - cranny_plan::PAPER_THRESHOLD).abs() < f64::EPSILON;
    if !(arguments.goal_threshold.is_finite() && arguments.goal_threshold >= 0.0) {
        let problem = format!("'{}' is no threshold; give a number, at least 0", arguments.goal_threshold);
        return Err(Failure::Flag { flag: "goal-threshold", problem });
    }
    match &mut problem.validity {
        Validity::Paper { threshold, .. } => *threshold = arguments.goal_threshold,
        Validity::Exact(_) if is_default => {}
        Validity::Exact(_) => {
            let problem = "only the paper criterion has a threshold; add --criterion paper".to_owned();
            return Err(Failure::Flag { flag: "goal-threshold", problem });
        }
    }
    Ok(())
}

fn page(answered: &Answered, scenario: &Scenario) -> String {
    let Answered { plan, .. } = answered;
    let statistics = &plan.statistics;
    let mut page = format!(
        "{}: {} by {} in {:.3} s (criterion {}, seed {})\n",
        plan.scenario,
        plan.outcome.name(),
        plan.planner,
        answered.planning_time_s,
        plan.criterion.name(),
        plan.seed
    );
    let mut line = |name: &str, value: String| {
        let _ = writeln!(page, "  {name:<12}{value}");
    };
    if let (Some(grasp), Some(translation), Some(rotation)) =
        (plan.grasp, plan.translation_error_m, plan.rotation_error_rad)
    {
        let count = scenario.grasps.len();
        let score = text::score(scenario.grasps.grasps()[grasp].score);
        line("grasp", format!("{grasp} of {count} (score {score})"));
        line("error", format!("{}, {}", millimetres(translation), degrees(rotation)));
    }
    if let Some(clearance) = plan.clearance_m {
        line("clearance", format!("{} or more along the whole path, proven", millimetres(clearance)));
    }
    if !plan.waypoints.is_empty() {
        line("path", format!("{} way points, length {:.3}", plan.waypoints.len(), plan.path_length));
    }
    line(
        "search",
        format!(
            "{} iterations, {} nodes, {} collision checks",
            statistics.iterations, statistics.nodes, statistics.collision_checks
        ),
    );
    if statistics.ik_attempts > 0 {
        line(
            "grasps",
            format!("{} goals tried, {} IK attempts", statistics.goals_tried, statistics.ik_attempts),
        );
    }
    line(
        "time",
        format!(
            "{:.3} s collision, {:.3} s proof, {:.3} s IK, {:.3} s nearest neighbours; {:.3} s to load",
            statistics.collision_time_s,
            statistics.proof_time_s,
            statistics.ik_time_s,
            statistics.nearest_time_s,
            answered.preparation_time_s
        ),
    );
    for fault in &answered.start_faults {
        line("start", fault.clone());
    }
    if plan.outcome == Outcome::Solved && !answered.valid {
        line("judged", "NOT valid; please report this".to_owned());
    }
    if plan.outcome == Outcome::BudgetExhausted {
        line("hint", "a longer --time-limit, another --seed or another --planner may find a path".to_owned());
    }
    if let Some(file) = answered.plan_file {
        line("written to", file.display().to_string());
    }
    page
}
