use std::path::{Path, PathBuf};
use std::time::Instant;

use cranny_file::counted;
use cranny_plan::{
    AuditSettings, Budget, CarryEnd, OptimiseSettings, PlaceGoal, PlaceSettings, Registry, TimingMethod,
};
use cranny_scenario::{PlanFile, read_waypoints, write_trajectory_csv};
use cranny_solve::{Carry, Request, Timing, solve};

use crate::Answer;
use crate::arguments::{Output, PlanArguments};
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::ik;
use crate::output_file;
use crate::plan_page::{self, Answered};
use crate::plan_steps;
use crate::plan_task::PlanTask;
use crate::progress::{SearchProgress, stop_on_interrupt};
use crate::start;
use crate::task::Demand;
use crate::text;

pub fn run(arguments: &PlanArguments, registry: &Registry, output: Output) -> Result<Answer, Failure> {
    if arguments.steps {
        let request = Request { registry: registry.clone(), ..request(arguments, None) };
        let file = destination(arguments, &arguments.task.id, output)?;
        return plan_steps::plan(arguments, &request, &file, output);
    }
    let begin = Instant::now();
    let demand = Demand { robust: arguments.robust, ..Demand::default() };
    let PlanTask { source, grasps, problem, deviations } =
        PlanTask::open(&arguments.task, &arguments.moveit, demand, output)?;
    let preparation_time_s = begin.elapsed().as_secs_f64();
    let carry = match &arguments.place {
        Some(place) => Some(put_down(arguments, problem.place(place)?)),
        None => carry(arguments, problem.robot().dof())?,
    };
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
        deviations,
        plan_file: is_written.then_some(file.as_path()),
        duration_s: answer.timed.as_ref().map(|timed| timed.trajectory.duration_s()),
        timing_time_s: answer.timed.as_ref().map(|timed| timed.time_s),
        trajectory_file: trajectory_file.as_deref(),
        clearance_limit: answer.audit.as_ref().and_then(|audit| audit.clearance_limit.as_ref()),
        untimed: answer.untimed.clone(),
        plan: &plan,
    };
    if !solved && !output.quiet {
        ik::filled_hand(&problem)?;
    }
    text::answer(&answered, || plan_page::page(&answered, &grasps), output)?;
    Ok(if solved { Answer::Done } else { Answer::No })
}

/// How `--place` puts the target down.
fn put_down(arguments: &PlanArguments, goal: &PlaceGoal) -> Carry {
    let clear_m = arguments.clear.map_or(PlaceSettings::CLEAR_M, |clear_mm| clear_mm / 1e3);
    let place = PlaceSettings { goal: goal.clone(), clear_m, then: arguments.then.into() };
    Carry { end: CarryEnd::Place(place), ..Carry::default() }
}

fn refuse_clear(arguments: &PlanArguments) -> Result<(), Failure> {
    let problem = || "how clear is asked with `--carry out` and `--place` alone".to_owned();
    arguments.clear.map_or(Ok(()), |_| Err(Failure::Flag { flag: "clear", problem: problem() }))
}

/// Where `--carry` leads.
fn carry(arguments: &PlanArguments, joints: usize) -> Result<Option<Carry>, Failure> {
    let Some(given) = arguments.carry.as_deref() else { return refuse_clear(arguments).map(|()| None) };
    if given != "out" {
        refuse_clear(arguments)?;
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
            let problem =
                format!("{}, but the robot has {}", counted(values.len(), "value"), counted(joints, "joint"));
            return Err(Failure::Flag { flag: "carry", problem });
        }
        None if !Path::new(given).exists() => {
            let problem = format!(
                "'{given}' is neither `home` nor `out`, nor {} with commas, nor a file",
                counted(joints, "value")
            );
            return Err(Failure::Flag { flag: "carry", problem });
        }
        None => read_waypoints(Path::new(given), joints)?,
    };
    Ok(Some(Carry { end: CarryEnd::Configurations(ends), ..Carry::default() }))
}

/// What the flags ask for.
fn request(arguments: &PlanArguments, carry: Option<Carry>) -> Request {
    Request {
        planner: arguments.planner.clone(),
        settings: arguments.set.iter().cloned().collect(),
        budget: Budget { iterations: arguments.iterations.unwrap_or(u64::MAX), time: arguments.time_limit },
        seed: arguments.seed,
        score: arguments.score.into(),
        min_score: arguments.min_score,
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
        robustness: true,
        ..Request::default()
    }
}

fn destination(arguments: &PlanArguments, id: &str, output: Output) -> Result<PathBuf, Failure> {
    let file = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{id}.plan.json")));
    output_file::check(&file, FileKind::Plan, output)?;
    if file.extension().is_none_or(|extension| extension != "json") {
        let problem = "a plan file ends in .json, by which `verify` and the others know it".to_owned();
        return Err(Failure::File { path: file, problem });
    }
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
