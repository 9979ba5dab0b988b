use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use cranny_grasp::GraspSet;
use cranny_plan::{
    Budget, Criterion, GraspFailure, OptimiseSettings, Optimised, Outcome, PlanError, PlanReport, Planner,
    Problem, ShortcutSettings, Shortened, Validity, optimise, path_length, search, shortcut, verify,
};
use cranny_scenario::{PlanBudget, PlanFile, PlanMargins, PlanOptimisation, PlanTiming};
use serde::Serialize;

use crate::Answer;
use crate::arguments::{Output, PlanArguments};
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::ik;
use crate::output_file;
use crate::plan_task::PlanTask;
use crate::progress::{SearchProgress, stop_on_interrupt};
use crate::start;
use crate::text::{self, degrees, millimetres};
use crate::timing::{Timing, trajectory_file};

/// What `plan --json` prints; the keys stay.
#[derive(Serialize)]
struct Answered<'a> {
    #[serde(flatten)]
    plan: &'a PlanFile,
    planning_time_s: f64,
    preparation_time_s: f64,
    shortcut_time_s: Option<f64>,
    iterations: u64,
    valid: bool,
    start_faults: Vec<String>,
    plan_file: Option<&'a Path>,
    duration_s: Option<f64>,
    timing_time_s: Option<f64>,
    trajectory_file: Option<&'a Path>,
    /// Why there is no trajectory.
    #[serde(skip)]
    untimed: Option<String>,
}

pub fn run(arguments: &PlanArguments, output: Output) -> Result<Answer, Failure> {
    let named = arguments.planner.as_deref().map(cranny_plan::planner).transpose()?;
    let begin = Instant::now();
    let PlanTask { id, grasps, mut problem, margins } =
        PlanTask::open(&arguments.task, &arguments.moveit, None, PlanMargins::default(), output)?;
    let preparation_time_s = begin.elapsed().as_secs_f64();
    let file = destination(arguments, &id, output)?;
    set_threshold(arguments, &mut problem)?;
    let planner = named.unwrap_or_else(|| cranny_plan::default_planner(problem.criterion()));
    let timing = Timing::new(arguments, &problem)?;
    let budget = Budget { iterations: arguments.iterations.unwrap_or(u64::MAX), time: arguments.time_limit };

    let mut progress = SearchProgress::new(output.quiet, stop_on_interrupt()?);
    let settings = optimise_settings(arguments, &problem)?;
    let mut optimisation = None;
    let mut report;
    if let Some(settings) = settings {
        let optimised =
            optimise(planner.as_ref(), &mut problem, &budget, settings, arguments.seed, &mut progress)?;
        optimisation = Some(of_optimised(&optimised, settings));
        report = optimised.report;
    } else {
        report = search(planner.as_ref(), &mut problem, &budget, arguments.seed, &mut progress)?;
    }
    progress.finish();
    let shortcut_time_s = if settings.is_some() { None } else { shorten(arguments, &problem, &mut report)? };

    let mut judged = judge(arguments, id, &problem, margins, planner.as_ref(), &report)?;
    let solved = report.outcome == Outcome::Solved && judged.valid;
    let timed = if solved { timing.time(&report.path)? } else { None };
    judged.plan.optimisation = optimisation;
    judged.plan.timing = timed.as_ref().map(|timed| PlanTiming::of(&timed.trajectory));
    let mut trajectory_file = None;
    if solved {
        trajectory_file =
            timed.as_ref().map(|timed| timed.write(arguments, &file, output)).transpose()?.flatten();
    }
    // A failed search is worth a look too, but never in the place of a plan that nobody named.
    let is_written = solved || arguments.output.is_some();
    if is_written {
        output_file::check(&file, FileKind::Plan, output)?;
        judged.plan.write(&file)?;
    }
    let answered = Answered {
        planning_time_s: report.statistics.planning_time_s,
        shortcut_time_s,
        preparation_time_s,
        iterations: report.statistics.iterations,
        valid: judged.valid,
        start_faults: start::faults(&problem),
        plan_file: is_written.then_some(file.as_path()),
        duration_s: timed.as_ref().map(|timed| timed.trajectory.duration_s()),
        timing_time_s: timed.as_ref().map(|timed| timed.timing_time_s),
        trajectory_file: trajectory_file.as_deref(),
        untimed: timing.hindrance(),
        plan: &judged.plan,
    };
    if !solved && !output.quiet {
        ik::filled_hand(&problem)?;
    }
    if output.json {
        text::print_json(&answered)?;
    } else if !output.quiet {
        text::print(&page(&answered, &grasps))?;
    }
    Ok(if solved { Answer::Done } else { Answer::No })
}

/// How to look for better paths, if that is asked for.
fn optimise_settings(
    arguments: &PlanArguments,
    problem: &Problem,
) -> Result<Option<OptimiseSettings>, Failure> {
    let Some(time) = arguments.optimise else { return Ok(None) };
    if !(arguments.score_weight.is_finite() && arguments.score_weight >= 0.0) {
        let problem = format!("'{}' is no weight; give a number, at least 0", arguments.score_weight);
        return Err(Failure::Flag { flag: "score-weight", problem });
    }
    match &problem.validity {
        Validity::Exact(_) => Ok(Some(OptimiseSettings { time, score_weight: arguments.score_weight })),
        Validity::Paper { .. } => {
            let problem = "only a proven path can be bettered; leave out --criterion paper".to_owned();
            Err(Failure::Flag { flag: "optimise", problem })
        }
    }
}

/// What the plan file says of it.
fn of_optimised(optimised: &Optimised, settings: OptimiseSettings) -> PlanOptimisation {
    PlanOptimisation {
        time_limit_s: settings.time.as_secs_f64(),
        score_weight: settings.score_weight,
        time_s: optimised.time_s,
        iterations: optimised.iterations,
        improvements: optimised.improvements.clone(),
    }
}

/// Shortens a path found under `exact`, unless the flags forbid it; the seconds that it took.
fn shorten(
    arguments: &PlanArguments,
    problem: &Problem,
    report: &mut PlanReport,
) -> Result<Option<f64>, PlanError> {
    if problem.criterion() != Criterion::Exact || report.path.is_empty() || arguments.no_shortcut {
        return Ok(None);
    }
    let settings = ShortcutSettings { seed: arguments.seed, ..ShortcutSettings::default() };
    let Shortened { path, time_s } = shortcut(problem, &report.path, settings)?;
    report.path = path;
    Ok(Some(time_s))
}

struct Judged {
    plan: PlanFile,
    valid: bool,
}

/// Every answer is judged like anybody's before it is called solved.
fn judge(
    arguments: &PlanArguments,
    id: String,
    problem: &Problem,
    margins: PlanMargins,
    planner: &dyn Planner,
    report: &PlanReport,
) -> Result<Judged, Failure> {
    let verification = if report.path.is_empty() { None } else { Some(verify(problem, &report.path)?) };
    let goal = verification.as_ref().and_then(|v| v.goal);
    let plan = PlanFile {
        scenario: id,
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
        not_checked: verification.as_ref().map_or_else(|| problem.not_checked(), |v| v.not_checked.clone()),
        path_length: path_length(&report.path),
        waypoints: report.path.clone(),
        timing: None,
        statistics: report.statistics,
        optimisation: None,
        failures: report.failures.clone(),
    };
    Ok(Judged { plan, valid: verification.is_some_and(|v| v.valid) })
}

fn destination(arguments: &PlanArguments, id: &str, output: Output) -> Result<PathBuf, Failure> {
    let file = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{id}.plan.json")));
    // Better now than after the search.
    output_file::check(&file, FileKind::Plan, output)?;
    if arguments.rate.is_some() {
        output_file::check(&trajectory_file(&file), FileKind::Trajectory, output)?;
    }
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

fn page(answered: &Answered, grasps: &GraspSet) -> String {
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
        let count = grasps.len();
        let score = text::score(grasps.grasps()[grasp].score);
        line("grasp", format!("{grasp} of {count} (score {score})"));
        line("error", format!("{}, {}", millimetres(translation), degrees(rotation)));
    }
    if let Some(clearance) = plan.clearance_m {
        let but_for = text::but_for(&plan.not_checked);
        line(
            "clearance",
            format!("{} or more along the whole path, proven{but_for}", millimetres(clearance)),
        );
    }
    for pair in &plan.not_checked {
        line("not checked", text::not_checked(pair));
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
    for improvement in plan.optimisation.iter().flat_map(|o| &o.improvements) {
        let (cost, iterations) = (improvement.cost, improvement.iterations);
        line("cost", format!("{cost:.3} after {:.3} s, {iterations} iterations", improvement.time_s));
    }
    for (reason, count) in counted(&plan.failures) {
        line("blocked", format!("{count:>4} grasps: {reason}"));
    }
    for fault in &answered.start_faults {
        line("start", fault.clone());
    }
    if plan.outcome == Outcome::Solved && !answered.valid {
        line("judged", "NOT valid; please report this".to_owned());
    }
    if plan.outcome == Outcome::BudgetExhausted {
        line("hint", "a longer --time-limit, another --seed or another --planner may find a path".to_owned());
    }
    if plan.outcome != Outcome::Solved && answered.plan_file.is_none() {
        line("to see it", "plan again with -o FILE, then `cranny view` that file".to_owned());
    }
    if let (Some(timing), Some(seconds)) = (&plan.timing, answered.timing_time_s) {
        let (duration_s, method) = (timing.duration_s, timing.method.name());
        let corners = if timing.blended { ", corners cut where proven" } else { "" };
        line("trajectory", format!("{duration_s:.3} s, {method}{corners}; {:.3} ms to time", seconds * 1e3));
    } else if let (true, Some(hindrance)) = (answered.valid, &answered.untimed) {
        line("trajectory", format!("none: {hindrance}"));
    }
    if let Some(file) = answered.trajectory_file {
        line("samples in", file.display().to_string());
    }
    if let Some(file) = answered.plan_file {
        line("written to", file.display().to_string());
    }
    page
}

/// How many grasps failed for each reason, the commonest first.
fn counted(failures: &[GraspFailure]) -> Vec<(String, usize)> {
    let mut counts: Vec<(String, usize)> = Vec::new();
    for failure in failures {
        let reason = failure.reason.sentence();
        match counts.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, count)) => *count += 1,
            None => counts.push((reason, 1)),
        }
    }
    counts.sort_by(|(a, m), (b, n)| n.cmp(m).then_with(|| a.cmp(b)));
    counts
}
