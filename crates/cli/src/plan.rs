use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use cranny_grasp::{GraspSet, ScoreKind};
use cranny_plan::{
    AuditSettings, Budget, CarryEnd, GraspFailure, Improvement, OptimiseSettings, Outcome, Registry,
    TimingMethod,
};
use cranny_scenario::{PlanFile, PlanShortening, PlanTiming, read_waypoints, write_trajectory_csv};
use cranny_solve::{Carry, Request, Timing, solve};
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
use crate::task::Demand;
use crate::text::{self, degrees, millimetres};

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

pub fn run(arguments: &PlanArguments, registry: &Registry, output: Output) -> Result<Answer, Failure> {
    let begin = Instant::now();
    let PlanTask { source, grasps, problem } =
        PlanTask::open(&arguments.task, &arguments.moveit, Demand::default(), output)?;
    let preparation_time_s = begin.elapsed().as_secs_f64();
    let carry = carry(arguments, problem.robot().dof())?;
    let request = Request { registry: registry.clone(), ..request(arguments, carry) };
    request.check(&problem)?;
    // Better now than after the search.
    let file = destination(arguments, &source.scenario, output)?;

    let mut progress = SearchProgress::new(output.quiet, stop_on_interrupt()?);
    let answer = solve(&problem, &request, &mut progress)?;
    progress.finish();

    let plan = PlanFile::of(&answer, &source);
    let solved = answer.is_solved();
    let trajectory_file = match (&answer.timed, arguments.rate) {
        (Some(timed), Some(rate_hz)) => {
            let beside = trajectory_file(&file);
            output_file::check(&beside, FileKind::Trajectory, output)?;
            write_trajectory_csv(&beside, &timed.trajectory, rate_hz)?;
            Some(beside)
        }
        _ => None,
    };
    // A failed search is worth a look too, but never in the place of a plan that nobody named.
    let is_written = solved || arguments.output.is_some();
    if is_written {
        output_file::check(&file, FileKind::Plan, output)?;
        plan.write(&file)?;
    }
    let answered = Answered {
        planning_time_s: answer.statistics.planning_time_s,
        shortcut_time_s: answer.shortening.map(|shortening| shortening.time_s),
        preparation_time_s,
        iterations: answer.statistics.iterations,
        valid: answer.is_valid(),
        start_faults: start::faults(&problem),
        plan_file: is_written.then_some(file.as_path()),
        duration_s: answer.timed.as_ref().map(|timed| timed.trajectory.duration_s()),
        timing_time_s: answer.timed.as_ref().map(|timed| timed.time_s),
        trajectory_file: trajectory_file.as_deref(),
        untimed: answer.untimed.clone(),
        plan: &plan,
    };
    if !solved && !output.quiet {
        ik::filled_hand(&problem)?;
    }
    text::answer(&answered, || page(&answered, &grasps), output)?;
    Ok(if solved { Answer::Done } else { Answer::No })
}

/// Where `--carry` leads.
fn carry(arguments: &PlanArguments, joints: usize) -> Result<Option<Carry>, Failure> {
    let Some(given) = arguments.carry.as_deref() else { return Ok(None) };
    if arguments.clear.is_some() && given != "out" {
        let problem = "how clear is asked with `--carry out` alone".to_owned();
        return Err(Failure::Flag { flag: "clear", problem });
    }
    match given {
        "home" => return Ok(Some(Carry::default())),
        "out" => {
            let clear_m = arguments.clear.map_or(CarryEnd::CLEAR_M, |clear_mm| clear_mm / 1e3);
            return Ok(Some(Carry { end: CarryEnd::Out { clear_m }, ..Carry::default() }));
        }
        _ => {}
    }
    let values: Option<Vec<f64>> = given.split(',').map(|value| value.trim().parse().ok()).collect();
    let ends = match values {
        Some(values) if values.len() == joints => vec![values],
        Some(values) => {
            let problem = format!("{} values, but the robot has {joints} joints", values.len());
            return Err(Failure::Flag { flag: "carry", problem });
        }
        None if !Path::new(given).exists() => {
            let problem =
                format!("'{given}' is neither `home` nor `out`, nor {joints} values with commas, nor a file");
            return Err(Failure::Flag { flag: "carry", problem });
        }
        None => read_waypoints(Path::new(given), joints)?,
    };
    Ok(Some(Carry { end: CarryEnd::Configurations(ends), ..Carry::default() }))
}

/// The first cost, each that is a twentieth below the one before it here, and the last: all stand in the plan file.
fn milestones(improvements: &[Improvement]) -> Vec<&Improvement> {
    const FALL: f64 = 0.05;
    let mut told: Vec<&Improvement> = Vec::new();
    for improvement in improvements {
        if told.last().is_none_or(|last| last.cost - improvement.cost >= FALL * last.cost.abs()) {
            told.push(improvement);
        }
    }
    let last = improvements.last().filter(|last| told.last().is_some_and(|told| told.cost > last.cost));
    told.extend(last);
    told
}

/// What the flags ask for.
fn request(arguments: &PlanArguments, carry: Option<Carry>) -> Request {
    Request {
        planner: arguments.planner.clone(),
        settings: arguments.set.iter().cloned().collect(),
        budget: Budget { iterations: arguments.iterations.unwrap_or(u64::MAX), time: arguments.time_limit },
        seed: arguments.seed,
        score: arguments.score.into(),
        goal_threshold: arguments.goal_threshold,
        keep_path: arguments.no_shortcut,
        optimise: arguments.optimise.map(|time| OptimiseSettings {
            time,
            score_weight: arguments.score_weight,
            cost: arguments.cost.into(),
            ..OptimiseSettings::default()
        }),
        carry,
        timing: Some(Timing {
            method: if arguments.jerk_limited {
                TimingMethod::JerkLimited
            } else {
                TimingMethod::TimeOptimal
            },
            blend: arguments.blend,
            is_demanded: arguments.rate.is_some(),
        }),
        audit: AuditSettings::default(),
        ..Request::default()
    }
}

fn destination(arguments: &PlanArguments, id: &str, output: Output) -> Result<PathBuf, Failure> {
    let file = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{id}.plan.json")));
    output_file::check(&file, FileKind::Plan, output)?;
    if arguments.rate.is_some() {
        output_file::check(&trajectory_file(&file), FileKind::Trajectory, output)?;
    }
    Ok(file)
}

/// Where the samples of a plan go: `021.plan.json` → `021.trajectory.csv`.
fn trajectory_file(plan_file: &Path) -> PathBuf {
    let name = plan_file.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.strip_suffix(".json").unwrap_or(&name);
    let stem = stem.strip_suffix(".plan").unwrap_or(stem);
    plan_file.with_file_name(format!("{stem}.trajectory.csv"))
}

/// Fingers that meet the object farther apart than this in their travel are told, in metres.
const UNEVEN_M: f64 = 1e-3;

/// What is carried, if anything is.
fn carried(plan: &PlanFile) -> Option<String> {
    let [_, lift_off, carry] = &plan.segments[..] else { return None };
    let [off, on] = [lift_off, carry].map(|segment| segment.waypoints.len());
    let object = lift_off.attached.as_deref()?;
    let opening = millimetres(lift_off.opening_m?);
    // What is less nobody sees.
    let uneven = lift_off.uneven_m.filter(|uneven_m| *uneven_m > UNEVEN_M);
    let uneven = uneven.map_or_else(String::new, |uneven_m| {
        format!(" (one meets it {} before the other: it will be pushed, or the hand)", millimetres(uneven_m))
    });
    Some(format!(
        "{object}, fingers {opening} apart{uneven}: {off} way points to lift it off, {on} to where it goes"
    ))
}

/// When the path is run through, and what it took to find that.
fn timed(timing: &PlanTiming, seconds: f64) -> String {
    let corners = if timing.blended { ", corners cut where proven" } else { "" };
    let closes = timing.closing_s.map_or_else(String::new, |[begin_s, end_s]| {
        format!(", the hand closes from {begin_s:.3} to {end_s:.3} s")
    });
    let (duration_s, method) = (timing.duration_s, timing.method.name());
    format!("{duration_s:.3} s, {method}{corners}{closes}; {:.3} ms to time", seconds * 1e3)
}

/// What the search took, and what for.
fn times(answered: &Answered) -> String {
    let statistics = &answered.plan.statistics;
    format!(
        "{} collision, {} proof, {} IK, {} nearest neighbours; {} to load",
        text::seconds(statistics.collision_time_s),
        text::seconds(statistics.proof_time_s),
        text::seconds(statistics.ik_time_s),
        text::seconds(statistics.nearest_time_s),
        text::seconds(answered.preparation_time_s)
    )
}

/// What came after the search, and how long that took.
fn shortened(shortening: &PlanShortening, seconds: f64) -> String {
    let searches = match shortening.searches {
        0 => String::new(),
        searches => format!(", with {searches} further searches"),
    };
    format!("in {}{searches}", text::seconds(seconds))
}

fn page(answered: &Answered, grasps: &GraspSet) -> String {
    let Answered { plan, .. } = answered;
    let statistics = &plan.statistics;
    let mut page = format!(
        "{}: {} by {} in {} (criterion {}, seed {})\n",
        plan.scenario,
        plan.outcome.name(),
        plan.planner,
        text::seconds(answered.planning_time_s),
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
        let ends_at = &grasps.grasps()[grasp];
        let (name, score) = match plan.score {
            ScoreKind::Geometric => ("score", ends_at.score),
            ScoreKind::Physics => ("robust score", ends_at.robust.map(|robust| robust.score())),
        };
        line("grasp", format!("{grasp} of {count} ({name} {})", text::score(score)));
        line("error", format!("{}, {}", millimetres(translation), degrees(rotation)));
    }
    if let Some(grasp) = &plan.own_grasp {
        line("grasp", text::own_grasp(grasp));
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
    if let Some(carried) = carried(plan) {
        line("carries", carried);
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
    line("time", times(answered));
    if let (Some(shortening), Some(seconds)) = (&plan.shortening, answered.shortcut_time_s) {
        line("shortened", shortened(shortening, seconds));
    }
    let improvements = plan.optimisation.as_ref().map_or(&[][..], |optimisation| &optimisation.improvements);
    for Improvement { cost, iterations, time_s } in milestones(improvements) {
        line("cost", format!("{cost:.3} after {time_s:.3} s, {iterations} iterations"));
    }
    for (reason, count) in GraspFailure::counted(&plan.failures) {
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
        line(
            "to see it",
            "plan again with -o FILE, then `cranny view` the scenario with that file".to_owned(),
        );
    }
    if let (Some(timing), Some(seconds)) = (&plan.timing, answered.timing_time_s) {
        line("trajectory", timed(timing, seconds));
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
