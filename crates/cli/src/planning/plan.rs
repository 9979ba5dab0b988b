use std::path::{Path, PathBuf};
use std::time::Instant;

use cranny_collision::Margins;
use cranny_file::counted;
use cranny_grasp::ScoreKind;
use cranny_path::TimingMethod;
use cranny_plan::Registry;
use cranny_record::{
    CarryGoal, PlanFile, PlanOptions, PlanSource, SpeedOptions, TaskSelection, default_grasp_margin_m,
    read_waypoints, write_trajectory_csv,
};
use cranny_scenario::STEPS;
use cranny_sim::{SimulatedAnswer, solve_in_physics};
use cranny_solve::solve;
use cranny_task::{Move, Problem, TaskError};

use crate::arguments::{Output, PlanArguments};
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::planning::plan_page::{self, Answered};
use crate::planning::plan_task::PlanTask;
use crate::planning::task::Demand;
use crate::planning::{certify, ik};
use crate::progress::{SearchProgress, stop_on_interrupt};
use crate::{Answer, output_file, start, text};

pub fn run(arguments: &PlanArguments, registry: &Registry, output: Output) -> Result<Answer, Failure> {
    let begin = Instant::now();
    let PlanArguments { carry, place, steps, named_task, robust, .. } = arguments;
    let goes_on = carry.is_some() || place.is_some() || *steps || named_task.is_some();
    if arguments.task.is_upright() && !goes_on {
        let problem = "nothing is carried in this task".to_owned();
        return Err(Failure::Flag { flag: "upright", problem });
    }
    let margins = Margins { grasp_margin_m: default_grasp_margin_m(goes_on, *robust), ..Margins::default() };
    let demand = Demand { robust: *robust, margins, ..Demand::default() };
    let PlanTask { source, grasps, problem, mut deviations, tool_m_s, scenario } =
        PlanTask::open(&arguments.task, &arguments.moveit, demand, output)?;
    deviations.extend(goes_on.then(|| unsupported_target(&problem)).transpose()?.flatten());
    let preparation_time_s = begin.elapsed().as_secs_f64();
    let ask = PlanOptions { registry: registry.clone(), tool_m_s, ..ask(arguments, problem.robot().dof())? };
    let (request, task) = ask.request(&problem, scenario.as_ref())?;
    let source = PlanSource { task, ..source };
    // Checks the output file before the search.
    let file = destination(arguments, &source.scenario, output)?;
    arguments.certificate.iter().try_for_each(|to| output_file::check(to, FileKind::Certificate, output))?;

    let mut progress = SearchProgress::new(output.quiet, stop_on_interrupt());
    let begin_of_solving = Instant::now();
    let tries = arguments.try_in_physics.zip(scenario.as_ref());
    let SimulatedAnswer { answer, tries } = match tries {
        Some((most, scenario)) => {
            let most = usize::try_from(most).unwrap_or(usize::MAX);
            let asked = (scenario, &problem);
            solve_in_physics(asked, (&request, &source), most, &mut progress, |_| {})?
        }
        None => SimulatedAnswer { answer: solve(&problem, &request, &mut progress)?, tries: Vec::new() },
    };
    progress.finish();
    let solving_time_s = begin_of_solving.elapsed().as_secs_f64();

    let plan = PlanFile { tries, ..PlanFile::of(&answer, &source) };
    let solved = answer.is_solved() && plan.tries.last().is_none_or(|last| last.as_planned);
    let trajectory_file = match (&answer.timed, arguments.rate) {
        (Some(timed), Some(rate_hz)) => {
            let beside = trajectory_file(&file);
            output_file::check(&beside, FileKind::Trajectory, output)?;
            write_trajectory_csv(&beside, &timed.trajectory, rate_hz)?;
            Some(beside)
        }
        _ => None,
    };
    // A failed search is useful too, but it never replaces a plan without an explicit --output.
    let is_written = solved || arguments.output.is_some();
    if is_written {
        output_file::check(&file, FileKind::Plan, output)?;
        plan.write(&file)?;
    }
    let to = arguments.certificate.as_deref().filter(|_| solved);
    let certified = to.map(|to| certify::write(&source.scenario, &problem, &plan, to, output)).transpose()?;
    let planning_time_s = answer.statistics.planning_time_s;
    let shortcut_time_s = answer.shortening.map(|shortening| shortening.time_s);
    let timing_time_s = answer.timed.as_ref().map(|timed| timed.time_s);
    let optimisation_time_s = answer.optimisation.as_ref().map(|optimisation| optimisation.time_s);
    let others_s = [optimisation_time_s, shortcut_time_s, timing_time_s];
    let stated_time_s = planning_time_s + others_s.into_iter().flatten().sum::<f64>();
    let answered = Answered {
        planning_time_s,
        shortcut_time_s,
        preparation_time_s,
        judging_time_s: (solving_time_s - stated_time_s).max(0.0),
        iterations: answer.statistics.iterations,
        valid: answer.is_valid(),
        start_faults: start::faults(&problem),
        deviations,
        plan_file: is_written.then_some(file.as_path()),
        duration_s: answer.timed.as_ref().map(|timed| timed.trajectory.duration_s()),
        timing_time_s,
        trajectory_file: trajectory_file.as_deref(),
        clearance_limit: answer.audit.as_ref().and_then(|audit| audit.clearance_limit.as_ref()),
        makes_first_grasps: request.makes_first_grasps(&problem),
        untimed: answer.untimed.clone(),
        plan: &plan,
    };
    if !solved && !output.quiet {
        ik::filled_hand(&problem)?;
    }
    // A printed load is computed and not taken from a file.
    let computed =
        || Some(&plan).filter(|plan| plan.score == ScoreKind::Load).and_then(|_| problem.loaded_grasps());
    text::answer(&answered, || plan_page::page(&answered, &computed().unwrap_or(grasps)), output)?;
    if let Some(certified) = &certified {
        text::note(certified.line().trim_end())?;
    }
    let is_as_asked = certified.is_none_or(|certified| certified.is_certified());
    Ok(if solved && is_as_asked { Answer::Done } else { Answer::No })
}

/// Describes a target that rests on nothing; `None` for one with a support.
fn unsupported_target(problem: &Problem) -> Result<Option<String>, Failure> {
    let Some((cell, target)) = problem.cell().zip(problem.target()) else { return Ok(None) };
    let resting = cell.resting(target).map_err(TaskError::from)?;
    let name = &cell.world().bodies()[target].name;
    Ok(resting.supports().next().is_none().then(|| {
        format!("'{name}' rests on nothing, and would fall before it is grasped (`cranny scenario check` simulates it)")
    }))
}

/// Parses the destination of `--carry`.
fn carry(given: &str, joints: usize) -> Result<CarryGoal, Failure> {
    match given {
        "home" => return Ok(CarryGoal::Home),
        "out" => return Ok(CarryGoal::Out),
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
                "'{given}' is not a valid destination: expected `home`, `out`, {} separated by commas, or a \
                 file",
                counted(joints, "value")
            );
            return Err(Failure::Flag { flag: "carry", problem });
        }
        None => read_waypoints(Path::new(given), joints)?,
    };
    Ok(CarryGoal::Configurations(ends))
}

/// Builds the request from the flags, for a robot with `joints` joints.
fn ask(arguments: &PlanArguments, joints: usize) -> Result<PlanOptions, Failure> {
    Ok(PlanOptions {
        planner: arguments.planner.clone(),
        settings: arguments.set.iter().cloned().collect(),
        seed: arguments.seed,
        time_limit: arguments.time_limit,
        iterations: arguments.iterations,
        score: score(arguments)?,
        min_score: arguments.min_score.map(|least| least.least),
        goal_threshold: arguments.goal_threshold,
        keep_path: arguments.no_shortcut,
        optimise: arguments.optimise,
        cost: arguments.cost.map(Into::into),
        score_weight: arguments.score_weight,
        timing: match arguments.timing {
            Some(timing) => Some(timing.into()),
            None => arguments.jerk_limited.then_some(TimingMethod::JerkLimited),
        },
        stops: arguments.stop_at_corners,
        paces: SpeedOptions {
            speed: arguments.speed.clone(),
            acceleration: arguments.acceleration.clone(),
            tool_speed: arguments.tool_speed.clone(),
            turn_speed: arguments.turn_speed.clone(),
        },
        torque: arguments.torque,
        is_timing_demanded: arguments.rate.is_some(),
        carry: arguments.carry.as_deref().map(|given| carry(given, joints)).transpose()?,
        place: arguments.place.clone(),
        goal_region: (!arguments.goal_region.is_empty())
            .then(|| Move::NamedRegions(arguments.goal_region.clone())),
        task: {
            let steps = arguments.steps.then(|| STEPS.to_owned());
            steps.or_else(|| arguments.named_task.clone()).map(TaskSelection::Named)
        },
        then: arguments.then.map(Into::into),
        clear_m: arguments.clear.map(|clear_mm| clear_mm / 1e3),
        approach_m: arguments.approach.map(|approach_cm| approach_cm / 100.0),
        retreat_m: arguments.retreat.map(|retreat_cm| retreat_cm / 100.0),
        robust: arguments.robust,
        hold: arguments.hold,
        ..PlanOptions::default()
    })
}

/// Returns the kind of score that either of its flags requests.
fn score(arguments: &PlanArguments) -> Result<Option<ScoreKind>, Failure> {
    let asked = arguments.score.map(ScoreKind::from);
    match (asked, arguments.min_score.and_then(|least| least.kind)) {
        (Some(asked), Some(of_least)) if asked != of_least => {
            let (asked, of_least) = (asked.name(), of_least.name());
            let problem = format!("its score, {of_least}, differs from that of --score, {asked}");
            Err(Failure::Flag { flag: "min-score", problem })
        }
        (asked, of_least) => Ok(asked.or(of_least)),
    }
}

fn destination(arguments: &PlanArguments, id: &str, output: Output) -> Result<PathBuf, Failure> {
    let file = arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{id}.plan.json")));
    output_file::check(&file, FileKind::Plan, output)?;
    if file.extension().is_none_or(|extension| extension != "json") {
        let problem = "the name of a plan file must end in .json".to_owned();
        return Err(Failure::File { path: file, problem });
    }
    if arguments.rate.is_some() {
        output_file::check(&trajectory_file(&file), FileKind::Trajectory, output)?;
    }
    Ok(file)
}

/// Returns the file for the samples of a plan: `021.plan.json` → `021.trajectory.csv`.
fn trajectory_file(plan_file: &Path) -> PathBuf {
    let name = plan_file.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.strip_suffix(".json").unwrap_or(&name);
    let stem = stem.strip_suffix(".plan").unwrap_or(stem);
    plan_file.with_file_name(format!("{stem}.trajectory.csv"))
}
