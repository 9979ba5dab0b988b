use std::path::{Path, PathBuf};
use std::time::Instant;

use cranny_collision::Margins;
use cranny_grasp::ScoreKind;
use cranny_plan::{Observer as _, Registry};
use cranny_record::{PlanFile, PlanOptions, PlanSource, default_grasp_margin_m, write_trajectory_csv};
use cranny_sim::solve_in_physics;
use cranny_solve::solve;
use cranny_task::{Problem, TaskError};

use crate::arguments::{Output, PlanArguments};
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::planning::obstruction::Obstruction;
use crate::planning::plan_page::{self, Answered};
use crate::planning::plan_request::ask;
use crate::planning::plan_task::PlanTask;
use crate::planning::task::Demand;
use crate::planning::{certify, explore, ik};
use crate::progress::{SearchProgress, stop_on_interrupt};
use crate::{Answer, output_file, start, text};

pub fn run(arguments: &PlanArguments, registry: &Registry, output: Output) -> Result<Answer, Failure> {
    if arguments.explore.explore {
        return explore::run(arguments, registry, output);
    }
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
    let (answer, tries) = match tries {
        Some((most, scenario)) => {
            let most = usize::try_from(most).unwrap_or(usize::MAX);
            let asked = (scenario, &problem);
            let found = solve_in_physics(asked, (&request, &source), most, &mut progress, |_| {})?;
            (found.answer, found.tries)
        }
        None => (solve(&problem, &request, &mut progress)?, Vec::new()),
    };
    let solving_time_s = begin_of_solving.elapsed().as_secs_f64();
    let failed = scenario.as_ref().filter(|_| !answer.is_solved() && !progress.should_stop());
    let obstruction = failed.map(|seen| Obstruction::of_failed(seen, &problem, &request, &mut progress));
    progress.finish();
    let obstruction = obstruction.transpose()?.flatten();

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
    // Without a path, it may be certain that none exists.
    let to = arguments.certificate.as_deref().filter(|_| solved || plan.waypoints.is_empty());
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
        is_spent_by_iterations: arguments.iterations.is_some_and(|most| answer.statistics.iterations >= most),
        untimed: answer.untimed.clone(),
        obstruction,
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
