//! `plan`: from a task to a proven, timed path.

use std::sync::Arc;
use std::time::Duration;

use cranny_plan::{
    Budget, Criterion, MotionLimits, OptimiseSettings, PlanError, PlanReport, Problem, ShortcutSettings,
    TimingMethod, Trajectory, Validity, default_planner, optimise as better, path_length, planner_with,
    search, shortcut as shorten, verify,
};
use cranny_scenario::{Demands, PlanBudget, PlanFile, PlanMargins, PlanOptimisation, PlanTiming};
use pyo3::prelude::*;

use crate::array::Configurations;
use crate::fault::{bad_value, fault};
use crate::interrupt::InterruptObserver;
use crate::json::settings_of;
use crate::plan::PyPlan;
use crate::task::Task;
use crate::verification::PyVerification;
use crate::whole;

/// Names of the planners that there are.
#[pyfunction]
pub fn planner_names() -> Vec<&'static str> {
    cranny_plan::planner_names()
}

/// Seconds as a duration, if they are some.
pub fn seconds(what: &str, value: f64) -> PyResult<Duration> {
    let wrong = || bad_value(format!("{what} is {value}, but a positive number of seconds is expected"));
    if value > 0.0 { Duration::try_from_secs_f64(value).map_err(|_| wrong()) } else { Err(wrong()) }
}

/// Plans `scenario` (a Scenario or a MoveItProblem) and returns a Plan, which is true if a path was found and holds.
///
/// `planner`: one of `planner_names()`; None: the best for the criterion. `settings`: what differs from its
/// defaults. The same `seed` and `iterations` give the same way points on every machine; `time_limit_s` (s) may
/// only cut the search short. `margin_m`, `grasp_margin_m`: clearances (m) that every proof must show;
/// `strict_pairs`: pairs of links that touch in every sample are checked too, see `plan.not_checked`. A path under
/// "exact" is then shortened, unless `shortcut` is False; with `optimise_s`, better paths are looked for so many
/// seconds, `score_weight` being what a grasp of score 1 is worth in units of path length. The path gets its time:
/// `jerk_limited` within limits of jerk too, `blend` with corners cut where that is proven free.
///
/// No path within the budget is an answer, no exception: see `plan.outcome`. Ctrl-C stops the search at once.
#[pyfunction]
#[pyo3(signature = (scenario, planner=None, *, seed=0, time_limit_s=120.0, iterations=None, margin_m=0.0,
    grasp_margin_m=0.0, strict_pairs=false, settings=None, shortcut=true, optimise_s=None, score_weight=1.0, jerk_limited=false,
    blend=false))]
#[allow(clippy::too_many_arguments, clippy::fn_params_excessive_bools)] // The keywords of the Python function.
pub fn plan(
    scenario: &Bound<'_, PyAny>,
    planner: Option<&str>,
    #[pyo3(from_py_with = whole::seed)] seed: u64,
    time_limit_s: f64,
    #[pyo3(from_py_with = whole::iterations)] iterations: Option<u64>,
    margin_m: f64,
    grasp_margin_m: f64,
    strict_pairs: bool,
    settings: Option<&Bound<'_, PyAny>>,
    shortcut: bool,
    optimise_s: Option<f64>,
    score_weight: f64,
    jerk_limited: bool,
    blend: bool,
) -> PyResult<PyPlan> {
    let py = scenario.py();
    let margins = PlanMargins { margin_m, grasp_margin_m };
    let mut task = Task::of(scenario, &Demands { margin_m, grasp_margin_m })?;
    if strict_pairs {
        task.problem = task.problem.checking_all_pairs();
    }
    let settings = settings_of(settings)?;
    let planner = planner.unwrap_or_else(|| default_planner(task.problem.criterion()).name());
    let planner = planner_with(planner, &settings).map_err(fault)?;
    let budget =
        Budget { iterations: iterations.unwrap_or(u64::MAX), time: seconds("time_limit_s", time_limit_s)? };
    let optimise = optimise_settings(&task.problem, optimise_s, score_weight)?;
    let timing = Timing {
        method: if jerk_limited { TimingMethod::JerkLimited } else { TimingMethod::TimeOptimal },
        blend,
    };

    let mut observer = InterruptObserver::new();
    let found = py.detach(|| match optimise {
        Some(settings) => better(planner.as_ref(), &mut task.problem, &budget, settings, seed, &mut observer)
            .map(|optimised| {
                let told = PlanOptimisation {
                    time_limit_s: settings.time.as_secs_f64(),
                    score_weight: settings.score_weight,
                    time_s: optimised.time_s,
                    iterations: optimised.iterations,
                    improvements: optimised.improvements,
                };
                (optimised.report, Some(told))
            }),
        None => search(planner.as_ref(), &mut task.problem, &budget, seed, &mut observer)
            .map(|report| (report, None)),
    });
    // Ctrl-C goes before whatever the search says of it.
    observer.result()?;
    let (mut report, optimisation) = found.map_err(fault)?;
    if shortcut && optimisation.is_none() {
        py.detach(|| shortened(&task.problem, &mut report, seed)).map_err(fault)?;
    }
    let judged = py.detach(|| -> Result<_, PlanError> {
        let PlanReport { path, .. } = &report;
        let verification = if path.is_empty() { None } else { Some(verify(&task.problem, path)?) };
        let trajectory = match &verification {
            Some(verification) if verification.valid => timing.time(&task.problem, path)?,
            _ => None,
        };
        Ok((verification, trajectory))
    });
    let (verification, trajectory) = judged.map_err(fault)?;
    let goal = verification.as_ref().and_then(|verification| verification.goal);
    let file = PlanFile {
        scenario: task.id.clone(),
        robot: task.robot_file.as_ref().map(|file| file.display().to_string()),
        geometry: None,
        planner: planner.name().to_owned(),
        settings: planner.settings(),
        criterion: task.problem.criterion(),
        goal_threshold: match &task.problem.validity {
            Validity::Paper { threshold, .. } => Some(*threshold),
            Validity::Exact(_) => None,
        },
        seed,
        version: PlanFile::VERSION.to_owned(),
        outcome: report.outcome,
        margins,
        budget: PlanBudget { iterations, time_limit_s: Some(time_limit_s) },
        joint_names: task.problem.robot.joint_names().to_vec(),
        grasp: goal.map(|goal| goal.grasp),
        translation_error_m: goal.map(|goal| goal.translation_error_m),
        rotation_error_rad: goal.map(|goal| goal.rotation_error_rad),
        clearance_m: verification.as_ref().and_then(|verification| verification.clearance_m),
        clearances_per_edge_m: verification
            .as_ref()
            .map(|v| v.clearances_per_edge_m.clone())
            .unwrap_or_default(),
        not_checked: verification
            .as_ref()
            .map_or_else(|| task.problem.not_checked(), |v| v.not_checked.clone()),
        path_length: path_length(&report.path),
        waypoints: std::mem::take(&mut report.path),
        timing: trajectory.as_ref().map(PlanTiming::of),
        statistics: report.statistics,
        optimisation,
        failures: report.failures.clone(),
    };
    Ok(PyPlan {
        task,
        file,
        trajectory: trajectory.map(Arc::new),
        is_valid: verification.is_some_and(|verification| verification.valid),
        failures: report.failures,
    })
}

/// How to look for better paths, if that is asked for.
fn optimise_settings(
    problem: &Problem,
    optimise_s: Option<f64>,
    score_weight: f64,
) -> PyResult<Option<OptimiseSettings>> {
    let Some(time_s) = optimise_s else { return Ok(None) };
    if let Validity::Paper { .. } = problem.validity {
        return Err(bad_value("optimise_s: only a proven path can be bettered, under the exact criterion"));
    }
    if !(score_weight.is_finite() && score_weight >= 0.0) {
        return Err(bad_value(format!("score_weight is {score_weight}, but must be finite and at least 0")));
    }
    Ok(Some(OptimiseSettings { time: seconds("optimise_s", time_s)?, score_weight }))
}

/// Judges a path (N, dof), whoever made it, by the criterion of `scenario` (a Scenario or a MoveItProblem), as
/// `cranny verify` does; `strict_pairs` as in `plan`.
#[pyfunction]
#[pyo3(signature = (scenario, path, *, margin_m=0.0, grasp_margin_m=0.0, strict_pairs=false))]
pub fn verify_path(
    scenario: &Bound<'_, PyAny>,
    path: &Bound<'_, PyAny>,
    margin_m: f64,
    grasp_margin_m: f64,
    strict_pairs: bool,
) -> PyResult<PyVerification> {
    let mut task = Task::of(scenario, &Demands { margin_m, grasp_margin_m })?;
    if strict_pairs {
        task.problem = task.problem.checking_all_pairs();
    }
    let robot = &task.problem.robot;
    let path = Configurations::read(path, "path", robot)?.rows(robot.dof())?;
    let verification = scenario.py().detach(|| verify(&task.problem, &path)).map_err(fault)?;
    Ok(PyVerification { verification })
}

fn shortened(problem: &Problem, report: &mut PlanReport, seed: u64) -> Result<(), PlanError> {
    if problem.criterion() == Criterion::Exact && !report.path.is_empty() {
        let settings = ShortcutSettings { seed, ..ShortcutSettings::default() };
        report.path = shorten(problem, &report.path, settings)?.path;
    }
    Ok(())
}

/// How a path is given its time.
pub struct Timing {
    pub method: TimingMethod,
    pub blend: bool,
}

impl Timing {
    /// None for a robot without the limits that this needs.
    pub fn time(&self, problem: &Problem, path: &[Vec<f64>]) -> Result<Option<Trajectory>, PlanError> {
        let Ok(limits) = MotionLimits::of(&problem.robot, self.method) else { return Ok(None) };
        match &problem.validity {
            Validity::Exact(cell) if self.blend => Trajectory::blended(path, &limits, cell).map(Some),
            _ => Trajectory::along(path, &limits).map(Some),
        }
    }
}
