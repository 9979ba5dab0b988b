//! `plan`: from a task to a proven, timed path.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use cranny_collision::Margins;
use cranny_path::{AuditSettings, TimingMethod, audit_with};
use cranny_plan::Observer;
use cranny_record::{CarryGoal, PlanFile, PlanOptions, SpeedOption, SpeedOptions, TaskSelection};
use cranny_robot::Robot;
use cranny_sim::solve_in_physics;
use cranny_solve::{PoseRadius, solve};
use cranny_task::Move;
use cranny_view::WatchedSearch;
use pyo3::prelude::*;

use crate::classes::{PyPlan, PyScenario, Task};
use crate::handover::array::Configurations;
use crate::handover::fault::{bad_value, fault};
use crate::handover::interrupt::InterruptObserver;
use crate::handover::json::{settings_of, value_of};
use crate::handover::whole;
use crate::live_page::PyLivePage;
use crate::verification::PyVerification;

/// Parses the destination of a carried object.
fn carry_of(value: &Bound<'_, PyAny>, robot: &Robot) -> PyResult<CarryGoal> {
    if let Ok(word) = value.extract::<String>() {
        return match word.as_str() {
            "home" => Ok(CarryGoal::Home),
            "out" => Ok(CarryGoal::Out),
            _ => {
                let expected = "\"home\", \"out\" or configurations are expected";
                Err(bad_value(format!("carry is '{word}', but {expected}")))
            }
        };
    }
    Ok(CarryGoal::Configurations(Configurations::read(value, "carry", robot)?.rows(robot.dof())?))
}

/// Parses limits of motions: a number, or numbers by mode.
fn pace_of(what: &str, value: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<SpeedOption>> {
    let Some(value) = value else { return Ok(Vec::new()) };
    if let Ok(value) = value.extract::<f64>() {
        return Ok(vec![SpeedOption { mode: None, value }]);
    }
    let expected = || bad_value(format!("{what}: a number or a dict from modes to numbers is expected"));
    let by_mode: BTreeMap<String, f64> = value.extract().map_err(|_| expected())?;
    let word = |(name, value): (String, f64)| {
        let mode =
            if name == "all" { None } else { Some(cranny_task::Mode::of_name(&name).map_err(bad_value)?) };
        Ok(SpeedOption { mode, value })
    };
    by_mode.into_iter().map(word).collect()
}

/// Parses goal regions.
fn goal_of(value: &Bound<'_, PyAny>) -> PyResult<Move> {
    let value = value_of("goal_region", "the name of a region, a region, or a list of them", value)?;
    PlanOptions::goal_of(value).map_err(|problem| bad_value(format!("goal_region: {problem}")))
}

/// Parses the name of a task, or its stages.
fn task_of(value: &Bound<'_, PyAny>) -> PyResult<TaskSelection> {
    if let Ok(name) = value.extract::<String>() {
        return Ok(TaskSelection::Named(name));
    }
    let stages = value_of("task", "the name of a task or a list of stages", value)?;
    let stages = serde_json::from_value(stages).map_err(|problem| bad_value(format!("task: {problem}")))?;
    Ok(TaskSelection::Stages(stages))
}

/// Checks the error of a pose (m, rad).
fn radius_of([translation_m, rotation_rad]: [f64; 2]) -> PyResult<PoseRadius> {
    if !(translation_m.is_finite() && translation_m >= 0.0 && rotation_rad.is_finite() && rotation_rad >= 0.0)
    {
        return Err(bad_value("robust is a translation (m) and a rotation (rad), both at least 0"));
    }
    Ok(PoseRadius { translation_m, rotation_rad })
}

/// Returns the names of the planners.
#[pyfunction]
pub fn planner_names() -> Vec<&'static str> {
    cranny_plan::Registry::default().names()
}

/// Converts a positive number of seconds to a duration.
pub fn seconds(what: &str, value: f64) -> PyResult<Duration> {
    let wrong = || bad_value(format!("{what} is {value}, but a positive number of seconds is expected"));
    if value > 0.0 { Duration::try_from_secs_f64(value).map_err(|_| wrong()) } else { Err(wrong()) }
}

/// Plans `scenario` (a Scenario or a MoveItProblem) and returns a Plan, which is true if a path was found and verified.
///
/// `start`: configuration (dof,) in which the path begins, such as the robot's current one, instead of the scenario's start.
///
/// `planner`: one of `planner_names()`; None: the best for the criterion. `settings`: values that differ from its defaults. The
/// same `seed` and `iterations` give the same way points on every machine; `time_limit_s` (s) may only end the search earlier.
///
/// `score`: score used to compare and filter grasps, "geometric", "physics" (the robust one, required of every grasp) or "load"
/// (computed; None: the stated load under "exact" if each grasp has one and `min_score` is None, else geometric); `min_score`:
/// minimum score, or load, of a goal grasp (None: no minimum). Under "paper", `goal_threshold` is the value of ½·mm + ½·deg
/// below which the goal is reached (None: 50).
///
/// `margin_m`, `grasp_margin_m`: clearances (m) that every proof must show (None: 1 mm if the plan continues after the grasp,
/// else 0). `strict_pairs`: also check the link pairs of `plan.not_checked`, except adjacent links that are never free.
///
/// Under "exact", the path is then shortened, unless `shortcut` is False. With `optimise_s`, the planner searches for better
/// paths for this many seconds, with a lower `cost` minus `score_weight` for a grasp of score 1: "length" (each joint weighted
/// by how far it moves the arm, in metres), "l2" (plain), "time" (seconds of the trajectory), "clearance" (the length, up to
/// eleven times as much where the robot is nearer than 20 mm to the world), "tool" (path length of the gripper frame in
/// metres), "turn" (its angle in radians), "mix" ("time" plus 1 s per metre and 0.3 s per radian of these). None: "mix", or
/// "length" for a robot without acceleration limits.
///
/// The path is then timed. `jerk_limited`: also keep jerk limits (None: if the robot states them; True: a robot without them is
/// refused). Corners are rounded if their blend is proven free, unless `blend` is False. `speed`, `acceleration`: fractions of
/// the joint limits, above 0 and at most 1. `tool_speed_m_s`, `turn_speed_deg_s`: maximum speed of the gripper frame in m/s,
/// and of its rotation in °/s. Each is a number for all motions, or a dict from modes ("reach", "carry", …; "all") to numbers;
/// by default, `speeds` of a `scenario.yaml` and `max_cartesian_speed` of a MoveIt request apply. An object is put down with at
/// most 0.1 m/s unless `tool_speed_m_s` states another speed for "set-down". `torque`: keep the force or torque of each joint
/// within the effort limit of the URDF, with the masses of the links and of the held object.
///
/// `upright_deg`: maximum tilt, above 0 and at most 180, of a held object relative to its orientation when grasped, proven
/// along the whole motion; `plan.tilt` is the result. `plan.tool` lists the tool bounds of the scenario.
///
/// `goal_region`: region of poses of the hand in which the path ends, instead of at a grasp: the name of one of
/// `scenario.regions`, or a dictionary of that form, or a list of them, any of which is a goal.
///
/// `carry`: destination of the grasped target, "home", "out", a configuration (dof,) or several (N, dof); "out" is any
/// configuration in which it is `clear_m` (m) clear of all bodies but floors. A grasp from which it cannot be carried there is
/// rejected; `plan.segments` lists the segments. `place`: name of one of `scenario.places`, where the target is put down
/// instead; the hand opens and moves `clear_m` away from it, and the robot returns "home", or with `then` "stay" stays. `task`:
/// name of one of `scenario.tasks`, or a list of stages of that form, planned in order; `plan.task` lists them. `approach_m`,
/// `retreat_m`: minimum lengths of the straight approach to each grasp, and of the straight retreat from each object that was
/// put down, within 1 mm and 1° (proven).
///
/// `robust`: required tolerance (m, rad) of the target's pose error, before the hand closes and in the hand; `plan.robustness`
/// lists all tolerated errors. `hold`: factor by which weight and inertia must be able to grow, at least, before the carried
/// object slips (weaker grasps are rejected, motions are slowed down accordingly; 0 disables the check); `plan.hold` is the
/// result. `try_in_physics`: maximum number of plans executed as by `simulate_plan`; if an object is lost or does not stay
/// where it was put down, the next plan excludes the failed grasp and uses the next seed; `plan.tries` lists the results.
/// `watch`: a page of `cranny.show(scenario, live=True)`, which shows the growing trees of the search, then the plan.
///
/// If no path is found within the budget, no exception is raised: see `plan.outcome`. Ctrl-C stops the search at once.
#[pyfunction]
#[pyo3(signature = (scenario, planner=None, *, start=None, seed=0, time_limit_s=120.0, iterations=None, margin_m=0.0,
    grasp_margin_m=None, strict_pairs=false, settings=None, goal_threshold=None, shortcut=true, optimise_s=None,
    cost=None, score_weight=1.0, jerk_limited=None, blend=true, speed=None,
    acceleration=None, tool_speed_m_s=None, turn_speed_deg_s=None, torque=false, upright_deg=None, score=None, min_score=None,
    carry=None, goal_region=None, place=None, task=None, then=None, clear_m=None, approach_m=None, retreat_m=None, robust=None, hold=1.5, try_in_physics=None, watch=None))]
#[allow(
    clippy::too_many_arguments,
    clippy::fn_params_excessive_bools,
    reason = "the keywords of the Python function"
)]
pub fn plan<'py>(
    scenario: &Bound<'py, PyAny>,
    planner: Option<&str>,
    start: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = whole::seed)] seed: u64,
    time_limit_s: f64,
    #[pyo3(from_py_with = whole::iterations)] iterations: Option<u64>,
    margin_m: f64,
    grasp_margin_m: Option<f64>,
    strict_pairs: bool,
    settings: Option<&Bound<'_, PyAny>>,
    goal_threshold: Option<f64>,
    shortcut: bool,
    optimise_s: Option<f64>,
    cost: Option<&str>,
    score_weight: f64,
    jerk_limited: Option<bool>,
    blend: bool,
    speed: Option<&Bound<'_, PyAny>>,
    acceleration: Option<&Bound<'_, PyAny>>,
    tool_speed_m_s: Option<&Bound<'_, PyAny>>,
    turn_speed_deg_s: Option<&Bound<'_, PyAny>>,
    torque: bool,
    upright_deg: Option<f64>,
    score: Option<&str>,
    min_score: Option<f64>,
    carry: Option<&Bound<'_, PyAny>>,
    goal_region: Option<&Bound<'_, PyAny>>,
    place: Option<String>,
    task: Option<&Bound<'_, PyAny>>,
    then: Option<&str>,
    clear_m: Option<f64>,
    approach_m: Option<f64>,
    retreat_m: Option<f64>,
    robust: Option<[f64; 2]>,
    hold: f64,
    try_in_physics: Option<usize>,
    watch: Option<&Bound<'_, PyLivePage>>,
) -> PyResult<PyPlan> {
    let py = scenario.py();
    let scenario = &match start {
        Some(start) => started(scenario, start)?,
        None => scenario.clone(),
    };
    let robust = robust.map(radius_of).transpose()?;
    let is_exact = scenario
        .cast::<PyScenario>()
        .is_ok_and(|scenario| scenario.get().scenario.criterion == cranny_task::Criterion::Exact);
    let goes_on = is_exact && (carry.is_some() || place.is_some() || task.is_some());
    let grasp_margin_m =
        grasp_margin_m.unwrap_or_else(|| cranny_record::default_grasp_margin_m(goes_on, robust));
    let tilt_rad = tilt_of(upright_deg, carry.is_some() || place.is_some() || task.is_some())?;
    let margins = Margins { margin_m, grasp_margin_m, tilt_rad, ..Margins::default() };
    let mut asked = Task::of(scenario, forgiving(scenario, margins, robust)?)?;
    if strict_pairs {
        asked.problem = asked.problem.checking_all_pairs();
    }
    let one_of = |what: &str, word: &str, known: &str| {
        bad_value(format!("{what} is '{word}', but {known} is expected"))
    };
    let ask = PlanOptions {
        planner: planner.map(str::to_owned),
        settings: settings_of(settings)?,
        seed,
        time_limit: seconds("time_limit_s", time_limit_s)?,
        iterations,
        score: score
            .map(|kind| kind.parse().map_err(|_| one_of("score", kind, "'geometric', 'physics' or 'load'")))
            .transpose()?,
        min_score,
        goal_threshold,
        keep_path: !shortcut,
        optimise: optimise_s.map(|time_s| seconds("optimise_s", time_s)).transpose()?,
        cost: cost
            .map(|cost| {
                let known = "'length', 'l2', 'time', 'clearance', 'tool', 'turn', 'smooth' or 'mix'";
                cost.parse().map_err(|_| one_of("cost", cost, known))
            })
            .transpose()?,
        score_weight,
        timing: jerk_limited.map(
            |limited| {
                if limited { TimingMethod::JerkLimited } else { TimingMethod::TimeOptimal }
            },
        ),
        stops: !blend,
        paces: SpeedOptions {
            speed: pace_of("speed", speed)?,
            acceleration: pace_of("acceleration", acceleration)?,
            tool_speed: pace_of("tool_speed_m_s", tool_speed_m_s)?,
            turn_speed: pace_of("turn_speed_deg_s", turn_speed_deg_s)?,
        },
        tool_m_s: asked.tool_m_s,
        torque,
        carry: carry.map(|carry| carry_of(carry, asked.problem.robot())).transpose()?,
        goal_region: goal_region.map(goal_of).transpose()?,
        place,
        task: task.map(task_of).transpose()?,
        then: then
            .map(|then| then.parse().map_err(|_| one_of("then", then, "'home' or 'stay'")))
            .transpose()?,
        clear_m,
        approach_m,
        retreat_m,
        robust,
        hold,
        ..PlanOptions::default()
    };
    let (request, named) = ask.request(&asked.problem, asked.scenario.as_deref()).map_err(fault)?;
    asked.source.task = named;
    let task = asked;
    let watched = watch.map(|page| page.get().watch(&task)).transpose()?;
    let mut observer = PlanObserver { interrupt: InterruptObserver::new(), watched };
    let found = py.detach(|| match (try_in_physics, &task.scenario) {
        (Some(most), Some(scenario)) => {
            let asked = (scenario.as_ref(), &task.problem);
            let found = solve_in_physics(asked, (&request, &task.source), most, &mut observer, |_| {});
            found.map(|found| (found.answer, found.tries)).map_err(fault)
        }
        (Some(_), None) => Err(bad_value("try_in_physics needs a Scenario")),
        (None, _) => {
            let answer = solve(&task.problem, &request, &mut observer).map_err(fault)?;
            Ok((answer, Vec::new()))
        }
    });
    let PlanObserver { interrupt, watched } = observer;
    // Ctrl-C takes precedence over the result of the search.
    interrupt.result()?;
    let (answer, tries) = found?;
    let file = PlanFile { tries, ..PlanFile::of(&answer, &task.source) };
    let is_valid = answer.is_valid();
    let trajectory = answer.timed.map(|timed| Arc::new(timed.trajectory));
    let (measured, differs, unjudged) = (file.clone(), Vec::new(), Vec::new());
    let plan = PyPlan { task, file, measured, differs, unjudged, trajectory, is_valid };
    if let (Some(page), Some(watched)) = (watch, watched) {
        let page = page.get();
        py.detach(|| page.show_with_tree(&plan, watched.end()))?;
    }
    Ok(plan)
}

/// Returns the maximum tilt of a carried object, in radians.
fn tilt_of(upright_deg: Option<f64>, carries: bool) -> PyResult<Option<f64>> {
    if let Some(degrees) = upright_deg.filter(|degrees| !(*degrees > 0.0 && *degrees <= 180.0)) {
        return Err(bad_value(format!("upright_deg is {degrees}, but it must be above 0 and at most 180")));
    }
    if upright_deg.is_some() && !carries {
        return Err(bad_value("upright: nothing is carried in this task"));
    }
    Ok(upright_deg.map(f64::to_radians))
}

/// Returns a scenario with this start.
fn started<'py>(scenario: &Bound<'py, PyAny>, start: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let scenario = scenario.cast::<PyScenario>().map_err(|_| bad_value("start needs a Scenario"))?;
    Ok(Bound::new(scenario.py(), PyScenario::with_start(scenario, start)?)?.into_any())
}

/// Observer that stops a search on Ctrl-C, and updates a page that watches it.
struct PlanObserver {
    interrupt: InterruptObserver,
    watched: Option<WatchedSearch>,
}

impl Observer for PlanObserver {
    fn node_added(&mut self, tree: usize, q: &[f64], parent: Option<usize>) {
        if let Some(watched) = &mut self.watched {
            watched.node_added(tree, q, parent);
        }
    }

    fn search_ended(&mut self) {
        if let Some(watched) = &mut self.watched {
            watched.search_ended();
        }
    }

    fn should_stop(&self) -> bool {
        self.interrupt.should_stop()
    }
}

/// Verifies a path (N, dof) from any source under the criterion of `scenario` (a Scenario or a MoveItProblem), as `cranny
/// verify` does; `strict_pairs` as in `plan`. With `any_end` it need not end at a goal.
#[pyfunction]
#[pyo3(signature = (scenario, path, *, margin_m=0.0, grasp_margin_m=0.0, strict_pairs=false, any_end=false))]
pub fn verify_path(
    scenario: &Bound<'_, PyAny>,
    path: &Bound<'_, PyAny>,
    margin_m: f64,
    grasp_margin_m: f64,
    strict_pairs: bool,
    any_end: bool,
) -> PyResult<PyVerification> {
    let mut task = Task::of(scenario, Margins { margin_m, grasp_margin_m, ..Margins::default() })?;
    if strict_pairs {
        task.problem = task.problem.checking_all_pairs();
    }
    let robot = &task.problem.robot();
    let path = Configurations::read(path, "path", robot)?.rows(robot.dof())?;
    let settings = AuditSettings { at_goal: !any_end, ..AuditSettings::default() };
    let audit = scenario.py().detach(|| audit_with(&task.problem, &path, settings)).map_err(fault)?;
    Ok(PyVerification { audit })
}

/// Returns margins that tolerate the pose error `robust` of the target of a scenario, if given.
fn forgiving(scenario: &Bound<'_, PyAny>, margins: Margins, robust: Option<PoseRadius>) -> PyResult<Margins> {
    match (robust, scenario.cast::<PyScenario>()) {
        (None, _) => Ok(margins),
        (_, Ok(scenario)) => cranny_record::margins_forgiving(&scenario.get().scenario, margins, robust)
            .map_err(|_| bad_value("robust: the scenario has no target, so no target pose can be uncertain")),
        (_, Err(_)) => Err(bad_value("robust needs a Scenario")),
    }
}
