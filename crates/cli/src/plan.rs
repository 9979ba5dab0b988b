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
    start_contacts: Vec<(String, String)>,
    plan_file: Option<&'a Path>,
}

pub fn run(arguments: &PlanArguments, output: Output) -> Result<Answer, Failure> {
    let planner = cranny_plan::planner(&arguments.planner)?;
    let begin = Instant::now();
    let Task { scenario, mut problem } = Task::open(&arguments.task)?;
    let preparation_time_s = begin.elapsed().as_secs_f64();
    let file = destination(arguments, &scenario)?;
    set_threshold(arguments, &mut problem)?;
    let budget = Budget { iterations: arguments.iterations.unwrap_or(u64::MAX), time: arguments.time_limit };

    let mut progress = SearchProgress::new(output.quiet, stop_on_interrupt()?);
    let report = planner.plan(&problem, &budget, arguments.seed, &mut progress)?;
    progress.finish();

    let judged = judge(arguments, &scenario, &problem, planner.as_ref(), &budget, &report)?;
    let solved = report.outcome == Outcome::Solved && judged.valid;
    if solved {
        judged.plan.write(&file)?;
    }
    let answered = Answered {
        planning_time_s: report.statistics.planning_time_s,
        preparation_time_s,
        iterations: report.statistics.iterations,
        valid: judged.valid,
        start_contacts: start_contacts(&problem, report.outcome),
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
    planner: &dyn Planner,
    budget: &Budget,
    report: &PlanReport,
) -> Result<Judged, Failure> {
    let verification = if report.path.is_empty() { None } else { Some(verify(problem, &report.path)?) };
    let goal = verification.as_ref().and_then(|v| v.goal);
    let plan = PlanFile {
        scenario: scenario.id.clone(),
        planner: planner.name().to_owned(),
        criterion: problem.criterion(),
        seed: arguments.seed,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        outcome: report.outcome,
        margins: PlanMargins {
            margin_m: arguments.task.margin / 1000.0,
            grasp_margin_m: arguments.task.grasp_margin / 1000.0,
        },
        budget: PlanBudget {
            iterations: arguments.iterations,
            time_limit_s: Some(budget.time.as_secs_f64()),
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
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(Failure::NoFolder { path: file })
        }
        _ => Ok(file),
    }
}

fn set_threshold(arguments: &PlanArguments, problem: &mut Problem) -> Result<(), Failure> {
    let is_default = (arguments.goal_threshold - cranny_plan::PAPER_THRESHOLD).abs() < f64::EPSILON;
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

fn start_contacts(problem: &Problem, outcome: Outcome) -> Vec<(String, String)> {
    match &problem.validity {
        Validity::Exact(cell) if outcome == Outcome::StartInvalid => cell
            .contacts(&problem.start, &mut cell.scratch())
            .iter()
            .map(|c| (cell.name(c.first).to_owned(), cell.name(c.second).to_owned()))
            .collect(),
        _ => Vec::new(),
    }
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
            "{:.3} s collision, {:.3} s IK, {:.3} s nearest neighbours; {:.3} s to load",
            statistics.collision_time_s,
            statistics.ik_time_s,
            statistics.nearest_time_s,
            answered.preparation_time_s
        ),
    );
    for (first, second) in &answered.start_contacts {
        line("start", format!("{first} touches {second}"));
    }
    if plan.outcome == Outcome::BudgetExhausted {
        line("hint", "a longer --time-limit, another --seed or another --planner may find a path".to_owned());
    }
    if let Some(file) = answered.plan_file {
        line("written to", file.display().to_string());
    }
    page
}
