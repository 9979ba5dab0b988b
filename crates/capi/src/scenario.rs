//! `CrannyScenario`: a task: robot, world, object, grasps or goals.

use std::ffi::{CString, c_char};
use std::mem::MaybeUninit;
use std::path::{Path, PathBuf};
use std::ptr::null;
use std::sync::Arc;

use cranny::collision::{Margins, World};
use cranny::record::PlanSource;
use cranny::scenario::{Geometry, GivenGrasps, MoveItOptions, MoveItProblem};
use cranny::task::Criterion;
use cranny::{Goal, OpenOptions, Problem, Robot, Scenario};
use serde::Deserialize;

use crate::boundary::{NumberBuffer, Numbers, Text, answered, given, guarded, put};
use crate::cell::CrannyCell;
use crate::error::{CrannyStatus, Fault};
use crate::grasps::CrannyGrasps;
use crate::options::{parsed, word};
use crate::robot::{CrannyRobot, check_dof};
use crate::text::c_text;
use crate::world::CrannyWorld;

/// Task: a robot, its surroundings, the object to grasp and its grasps, or goal configurations. It never changes; functions
/// that alter it make another.
#[derive(Debug)]
pub struct CrannyScenario {
    pub asked: Arc<Asked>,
    id: CString,
    notes: CString,
    start: Vec<f64>,
}

/// Task of a plan.
#[derive(Clone, Debug)]
pub struct Asked {
    pub scenario: Scenario,
    /// URDF that was given instead of the scenario's robot.
    robot_file: Option<PathBuf>,
    geometry: Option<Geometry>,
    given_grasps: GivenGrasps,
    /// Goal configurations instead of the grasps; any of them is a goal.
    goals: Option<Vec<Vec<f64>>>,
    /// Greatest speed of the gripper frame that the task demands, in m/s.
    pub tool_m_s: Option<f64>,
    /// Differences between the task and its files, in sentences.
    notes: Vec<String>,
}

impl Asked {
    fn of(scenario: Scenario) -> Self {
        Self {
            scenario,
            robot_file: None,
            geometry: None,
            given_grasps: GivenGrasps::Own,
            goals: None,
            tool_m_s: None,
            notes: Vec::new(),
        }
    }

    /// Returns the planning problem.
    pub fn problem(&self, margins: Margins) -> Result<Problem, Fault> {
        let problem = self.scenario.problem(margins)?;
        let Some(goals) = &self.goals else { return Ok(problem) };
        Ok(problem.with_goal(Goal::Configurations(goals.clone()))?)
    }

    /// Returns the source that a plan states.
    pub fn source(&self, margins: Margins) -> PlanSource {
        PlanSource {
            scenario: self.scenario.id.clone(),
            robot: self.robot_file.clone(),
            geometry: self.geometry,
            grasps: self.given_grasps.clone(),
            margins,
            task: None,
        }
    }

    fn boxed(self) -> Option<Box<CrannyScenario>> {
        let id = c_text(&self.scenario.id);
        let notes = c_text(&self.notes.join("\n"));
        let start = self.scenario.start.clone();
        Some(Box::new(CrannyScenario { asked: Arc::new(self), id, notes, start }))
    }
}

/// Scenario of a robot in a world, without a file.
fn scenario_of(id: String, robot: Arc<Robot>, world: World, start: Vec<f64>) -> Result<Scenario, Fault> {
    Ok(Scenario::bare(id, robot, world, Vec::new()).with_start(start)?)
}

/// Options of a scenario, in the words of Python's `Scenario`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Options {
    criterion: Option<String>,
    robot: Option<PathBuf>,
    geometry: Option<String>,
    grasps: Option<String>,
}

/// Opens the scenario that `what` names: a built-in id such as "021", a folder in Cranny's own layout or in the paper's
/// released one, or a packed .zip. "./021" is the folder. The caller frees it with cranny_scenario_free.
///
/// `options`: NULL, or a JSON object with any of "criterion" ("exact" or "paper"), "robot" (another robot: a built-in name, a
/// robot folder or a URDF), "geometry" ("scene" or "export", for a released scenario), "grasps" (a file of other grasps, or
/// "none": the planner makes its own).
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_open(
    what: Text<'_>,
    options: Text<'_>,
    scenario: Option<&mut MaybeUninit<Option<Box<CrannyScenario>>>>,
) -> CrannyStatus {
    guarded(|| {
        let what = what.read("what")?;
        let asked = parsed::<Options>(options)?;
        let geometry = word("geometry", asked.geometry.as_deref(), "'scene' or 'export'")?;
        let open = OpenOptions {
            criterion: word("criterion", asked.criterion.as_deref(), "'exact' or 'paper'")?,
            robot: asked.robot.clone(),
            geometry,
            grasps: GivenGrasps::of_text(asked.grasps.as_deref()),
        };
        let made = Asked {
            robot_file: asked.robot,
            geometry,
            given_grasps: open.grasps.clone(),
            ..Asked::of(Scenario::open(what, &open)?)
        };
        put(scenario, "scenario", made.boxed())
    })
}

/// Makes a scenario of a robot in a world. `start`: the start configuration, `dof` values; NULL with 0: the robot's own.
/// `target`: name of the body to grasp, or NULL. `grasps`: grasps of the target; NULL: the planner makes its own. Without a
/// target, set a goal with cranny_scenario_with_goals or cranny_scenario_with_grasps. The caller frees it with
/// cranny_scenario_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_new(
    robot: Option<&CrannyRobot>,
    world: Option<&CrannyWorld>,
    start: Numbers<'_>,
    dof: usize,
    target: Text<'_>,
    grasps: Option<&CrannyGrasps>,
    scenario: Option<&mut MaybeUninit<Option<Box<CrannyScenario>>>>,
) -> CrannyStatus {
    guarded(|| {
        let (robot, world) = (&given(robot, "robot")?.robot, given(world, "world")?.now()?);
        let start = if start.is_null() {
            let problem = "it is NULL, but the robot has no default start";
            robot.default_start().ok_or(Fault::Lacking { what: "start", problem })?
        } else {
            check_dof(robot, dof)?;
            start.finite("start", 1, dof)?
        };
        let mut made = scenario_of("scene".to_owned(), robot.clone(), world, start.to_vec())?;
        if let Some(name) = target.optional("target")? {
            made = made.with_target(name)?;
        }
        if let Some(grasps) = grasps {
            made = made.with_grasps(grasps.set.clone());
        }
        put(scenario, "scenario", Asked::of(made).boxed())
    })
}

/// Options of a problem of MoveIt.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct MoveItWords {
    robot: Option<PathBuf>,
    srdf: Option<PathBuf>,
}

/// Opens a planning scene and a motion plan request of MoveIt (YAML or JSON). The request's goals are configurations. The
/// caller frees the scenario with cranny_scenario_free.
///
/// `options`: NULL, or a JSON object with any of "robot" (a URDF) and "srdf"; otherwise the files beside the scene are taken
/// that are called like its robot_model_name.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_from_moveit(
    scene_path: Text<'_>,
    request_path: Text<'_>,
    options: Text<'_>,
    scenario: Option<&mut MaybeUninit<Option<Box<CrannyScenario>>>>,
) -> CrannyStatus {
    guarded(|| {
        let (scene, request) = (scene_path.read("scene_path")?, request_path.read("request_path")?);
        let MoveItWords { robot, srdf } = parsed(options)?;
        let robot_file = robot.clone();
        let options = MoveItOptions { robot, srdf };
        let opened = MoveItProblem::open(Path::new(scene), Path::new(request), &options)?;
        let made = Asked {
            robot_file,
            goals: Some(opened.goals),
            tool_m_s: opened.tool_speed_m_s,
            notes: opened.deviations.iter().map(ToString::to_string).collect(),
            ..Asked::of(scenario_of(opened.id, opened.robot, opened.world, opened.start)?)
        };
        put(scenario, "scenario", made.boxed())
    })
}

/// Frees a scenario. NULL is ignored. Cells and plans of it stay valid.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_free(scenario: Option<Box<CrannyScenario>>) {
    drop(scenario);
}

/// Returns the built-in id or the name of the folder, valid as long as the scenario; NULL for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_id(scenario: Option<&CrannyScenario>) -> *const c_char {
    answered(null(), || Ok(given(scenario, "scenario")?.id.as_ptr()))
}

/// Returns the differences between the scenario and MoveIt's files, a sentence in each line, valid as long as the scenario;
/// empty if there are none.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_notes(scenario: Option<&CrannyScenario>) -> *const c_char {
    answered(null(), || Ok(given(scenario, "scenario")?.notes.as_ptr()))
}

/// Makes a handle of the robot. The caller frees it with cranny_robot_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_robot(
    scenario: Option<&CrannyScenario>,
    robot: Option<&mut MaybeUninit<Option<Box<CrannyRobot>>>>,
) -> CrannyStatus {
    guarded(|| {
        let found = given(scenario, "scenario")?.asked.scenario.robot.clone();
        put(robot, "robot", Some(CrannyRobot::of(found)))
    })
}

/// Makes the robot's cell, with target and floor, always with the exact geometry. `margin_m`: required clearance (m) between any
/// two bodies or links; `grasp_margin_m`: that between the hand and the target or its support. The caller frees it with
/// cranny_cell_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_cell(
    scenario: Option<&CrannyScenario>,
    margin_m: f64,
    grasp_margin_m: f64,
    cell: Option<&mut MaybeUninit<Option<Box<CrannyCell>>>>,
) -> CrannyStatus {
    guarded(|| {
        let scenario = &given(scenario, "scenario")?.asked.scenario;
        let exact = Scenario { criterion: Criterion::Exact, ..scenario.clone() };
        let problem = exact.problem(Margins { margin_m, grasp_margin_m, ..Margins::default() })?;
        let lacking = Fault::Lacking { what: "scenario", problem: "it has no exact cell" };
        put(cell, "cell", Some(CrannyCell::of(problem.cell().ok_or(lacking)?.clone())))
    })
}

/// Makes a handle of the grasps. The caller frees it with cranny_grasps_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_grasps(
    scenario: Option<&CrannyScenario>,
    grasps: Option<&mut MaybeUninit<Option<Box<CrannyGrasps>>>>,
) -> CrannyStatus {
    guarded(|| {
        let set = given(scenario, "scenario")?.asked.scenario.grasps.clone();
        put(grasps, "grasps", Some(CrannyGrasps::of(set)))
    })
}

/// Writes the start configuration, `dof` values.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_start(
    scenario: Option<&CrannyScenario>,
    mut q: NumberBuffer<'_>,
    dof: usize,
) -> CrannyStatus {
    guarded(|| {
        let scenario = given(scenario, "scenario")?;
        check_dof(&scenario.asked.scenario.robot, dof)?;
        q.write("q", &scenario.start)
    })
}

/// Makes a scenario with another start, `dof` values. The caller frees it with cranny_scenario_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_with_start(
    scenario: Option<&CrannyScenario>,
    start: Numbers<'_>,
    dof: usize,
    altered: Option<&mut MaybeUninit<Option<Box<CrannyScenario>>>>,
) -> CrannyStatus {
    guarded(|| {
        let asked = &given(scenario, "scenario")?.asked;
        check_dof(&asked.scenario.robot, dof)?;
        let start = start.finite("start", 1, dof)?.to_vec();
        let made = Asked { scenario: asked.scenario.with_start(start)?, ..Asked::clone(asked) };
        put(altered, "altered", made.boxed())
    })
}

/// Makes a scenario with `rows` goal configurations, `rows` × `dof`, instead of grasps; any of them is a goal. The caller frees
/// it with cranny_scenario_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_with_goals(
    scenario: Option<&CrannyScenario>,
    goals: Numbers<'_>,
    rows: usize,
    dof: usize,
    altered: Option<&mut MaybeUninit<Option<Box<CrannyScenario>>>>,
) -> CrannyStatus {
    guarded(|| {
        let asked = &given(scenario, "scenario")?.asked;
        check_dof(&asked.scenario.robot, dof)?;
        let goals = goals.finite("goals", rows, dof)?.chunks_exact(dof.max(1)).map(<[f64]>::to_vec);
        let made = Asked { goals: Some(goals.collect()), ..Asked::clone(asked) };
        put(altered, "altered", made.boxed())
    })
}

/// Makes a scenario with other grasps. Without a target, each is a pose that the gripper frame may reach. The caller frees it
/// with cranny_scenario_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_scenario_with_grasps(
    scenario: Option<&CrannyScenario>,
    grasps: Option<&CrannyGrasps>,
    altered: Option<&mut MaybeUninit<Option<Box<CrannyScenario>>>>,
) -> CrannyStatus {
    guarded(|| {
        let asked = &given(scenario, "scenario")?.asked;
        let made = asked.scenario.with_grasps(given(grasps, "grasps")?.set.clone());
        put(altered, "altered", Asked { scenario: made, goals: None, ..Asked::clone(asked) }.boxed())
    })
}
