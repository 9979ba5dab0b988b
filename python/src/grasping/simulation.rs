//! `simulate_grasps`, `grasp_experiment`, `simulate_plan` and `plan_experiment`: grasps of a scenario and plans in physics.

use std::path::PathBuf;

use cranny_grasp::Hand;
use cranny_scenario::{Friction, Scenario, TargetPhysics, read_gripper};
use cranny_sim::{Disturbance, ExecutedPlan, GraspRow, GraspTest, PickPath, PlanExecution};
use cranny_spatial::Pose;
use cranny_task::robot_hand;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::classes::{PyPlan, PyScenario};
use crate::grasping::grasp_set::PyGrasps;
use crate::handover::fault::{bad_type, bad_value, fault};
use crate::handover::interrupt::interruptible;
use crate::handover::json::python_of;
use crate::handover::whole;

/// Maximum number of trials of a grasp; more would be a mistake.
const MOST_TRIALS: usize = 10_000;

/// Tests grasps of a scenario's target in physics, on all cores: the hand alone closes, lifts and shakes. Returns one
/// dictionary for each grasp, with the keys of `cranny simulate grasps --json`: grasp, outcome ("held", "slipped", "dropped",
/// "never-closed", "knocked-away"), translation_error_m, rotation_error_rad, held_s, contact_force_n, score, load (if the hand
/// has two flat pads: a dictionary of at_rest, in_motion, turn_rad, shift_m and width_m), and with `trials` also robust, a
/// dictionary of trials, held and score: each grasp is then tested that many more times with small errors, the same for all
/// grasps; `seed` draws others. A test does not start if the open hand overlaps the object by more than 1 mm ("knocked-away")
/// or a finger overlaps the surroundings ("never-closed").
///
/// `grasps`: in the planning frame; by default the scenario's own. `support_only`: of the surroundings, only the support of the
/// target. `gripper`: a YAML file; by default the hand of the scenario's robot. `mass_kg`, `friction` and `closing_force_n`
/// override the files. Ctrl-C stops the tests once those that run have ended.
#[pyfunction]
#[pyo3(
    signature = (scenario, grasps=None, *, support_only=false, gripper=None, mass_kg=None, friction=None,
        closing_force_n=None, trials=0, seed=0)
)]
#[allow(clippy::too_many_arguments, reason = "the keywords of the Python function")]
pub fn simulate_grasps<'py>(
    scenario: &Bound<'py, PyScenario>,
    grasps: Option<&Bound<'py, PyGrasps>>,
    support_only: bool,
    gripper: Option<PathBuf>,
    mass_kg: Option<f64>,
    friction: Option<f64>,
    closing_force_n: Option<f64>,
    #[pyo3(from_py_with = whole::count)] trials: usize,
    #[pyo3(from_py_with = whole::seed)] seed: u64,
) -> PyResult<Bound<'py, PyAny>> {
    let py = scenario.py();
    if trials > MOST_TRIALS {
        return Err(bad_value(format!("trials is {trials}, but at most {MOST_TRIALS} is allowed")));
    }
    let scenario = &scenario.get().scenario;
    let hand = hand_of(scenario, gripper, closing_force_n)?;
    let grasps = grasps.map_or_else(|| scenario.grasps.clone(), |grasps| grasps.get().set.clone());
    let instead =
        TargetPhysics { mass_kg, friction: friction.map(Friction::from), ..TargetPhysics::default() };
    let rows = interruptible(py, |stop| -> PyResult<Vec<GraspRow>> {
        let test = GraspTest::of_scenario(scenario, &hand, &instead, support_only).map_err(fault)?;
        let all: Vec<usize> = (0..grasps.len()).collect();
        Ok(test.rows(grasps.grasps(), &all, (trials, seed), &|| {}, stop))
    })?;
    python_of(py, &rows?)
}

fn hand_of(scenario: &Scenario, gripper: Option<PathBuf>, closing_force_n: Option<f64>) -> PyResult<Hand> {
    let mut hand = match gripper {
        Some(path) => read_gripper(&path).map_err(fault)?,
        None => robot_hand(&scenario.robot),
    };
    hand.closing_force_n = closing_force_n.unwrap_or(hand.closing_force_n);
    Ok(hand)
}

/// Returns the tests of `simulate_grasps` as a document for another engine, as `cranny simulate export` writes it: the model of
/// hand, object and surroundings as MJCF, the motion of the hand, the condition for a held object, and the grasps. A dictionary
/// for `cranny.mujoco_grasps.run_all`.
///
/// The arguments are those of `simulate_grasps`.
#[pyfunction]
#[pyo3(
    signature = (scenario, grasps=None, *, support_only=false, gripper=None, mass_kg=None, friction=None,
        closing_force_n=None)
)]
pub fn grasp_experiment<'py>(
    scenario: &Bound<'py, PyScenario>,
    grasps: Option<&Bound<'py, PyGrasps>>,
    support_only: bool,
    gripper: Option<PathBuf>,
    mass_kg: Option<f64>,
    friction: Option<f64>,
    closing_force_n: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = scenario.py();
    let scenario = &scenario.get().scenario;
    let hand = hand_of(scenario, gripper, closing_force_n)?;
    let set = grasps.map_or(&scenario.grasps, |grasps| &grasps.get().set);
    let poses: Vec<Pose> = set.grasps().iter().map(|grasp| grasp.world_from_gripper).collect();
    let instead =
        TargetPhysics { mass_kg, friction: friction.map(Friction::from), ..TargetPhysics::default() };
    let test =
        py.detach(|| GraspTest::of_scenario(scenario, &hand, &instead, support_only)).map_err(fault)?;
    python_of(py, &test.experiment(&poses))
}

/// Executes a plan in physics, as `cranny simulate plan` does: the arm follows the timed path exactly, the hand closes with its
/// closing force, and the arm lifts straight up by `lift_m`, or follows the rest of a plan that carries the object on.
///
/// Returns a dictionary with the keys of `cranny simulate plan --json`: scenario, outcome ("held", "slipped", "dropped",
/// "never-closed", "knocked-away"; for a released object "placed" at its goal, or "misplaced"), is_kept (in the hand up to the
/// end or the release, without slipping too far), is_in_hand, for a plan that puts it down released (pose error at the release)
/// and placed (pose error 2 s after the arm has stopped: translation_m, rotation_rad, is_there), reach_s, contacts, pushed_m,
/// lift_m, rose_m, translation_error_m, rotation_error_rad, held_s, contact_force_n, position_m, quaternion_xyzw, simulated_s;
/// for a plan with several picks scenario, as_planned and steps, a dictionary for each. For several plans, which are executed
/// on all cores, a list of them in their order.
///
/// `mass_kg`, `friction` and `closing_force_n` override the files; `disturb` is a seed of errors: of the hand 2 mm and 2° per
/// axis, of the friction 30 %, of the mass 20 %.
#[pyfunction]
#[pyo3(signature = (plan, *, lift_m=0.03, mass_kg=None, friction=None, closing_force_n=None, disturb=None))]
pub fn simulate_plan<'py>(
    plan: &Bound<'py, PyAny>,
    lift_m: f64,
    mass_kg: Option<f64>,
    friction: Option<f64>,
    closing_force_n: Option<f64>,
    disturb: Option<u64>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = plan.py();
    let physics =
        TargetPhysics { mass_kg, friction: friction.map(Friction::from), ..TargetPhysics::default() };
    let disturbance = disturb.map(Disturbance::of_execution).unwrap_or_default();
    let instead = Instead { physics, closing_force_n, disturbance };
    if let Ok(plan) = plan.cast::<PyPlan>() {
        let plan = plan.get();
        return python_of(py, &py.detach(|| instead.execute(plan, lift_m))?);
    }
    let plans: Vec<Bound<'py, PyPlan>> =
        plan.extract().map_err(|_| bad_type("plan: a Plan or a sequence of plans is expected"))?;
    let plans: Vec<&PyPlan> = plans.iter().map(Bound::get).collect();
    let rows = interruptible(py, |stop| {
        // An exception replaces all rows.
        let execute = |plan: &&PyPlan| (!stop()).then(|| instead.execute(plan, lift_m)).transpose();
        plans.par_iter().map(execute).collect::<PyResult<Option<Vec<ExecutedPlan>>>>()
    })?;
    python_of(py, &rows?.unwrap_or_default())
}

/// Returns a plan of one pick as a document for another engine, as `cranny simulate plan --export` writes it: hand, object and
/// surroundings as MJCF, and the motions of the hand from the closing on. A dictionary for `cranny.mujoco_grasps.run_plan`. The
/// arguments are those of `simulate_plan`.
#[pyfunction]
#[pyo3(signature = (plan, *, lift_m=0.03, mass_kg=None, friction=None, closing_force_n=None))]
pub fn plan_experiment<'py>(
    plan: &Bound<'py, PyPlan>,
    lift_m: f64,
    mass_kg: Option<f64>,
    friction: Option<f64>,
    closing_force_n: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = plan.py();
    let physics =
        TargetPhysics { mass_kg, friction: friction.map(Friction::from), ..TargetPhysics::default() };
    let instead = Instead { physics, closing_force_n, disturbance: Disturbance::default() };
    let plan = plan.get();
    let experiment = py.detach(|| {
        let (execution, picks) = instead.execution(plan, lift_m)?;
        execution.experiment(&picks).map_err(fault)
    })?;
    let several = || bad_value("the plan has several picks; give a plan with a single pick");
    python_of(py, &experiment.ok_or_else(several)?)
}

/// Overrides of the properties in the files.
struct Instead {
    physics: TargetPhysics,
    closing_force_n: Option<f64>,
    disturbance: Disturbance,
}

impl Instead {
    fn execution<'a>(&self, plan: &'a PyPlan, lift_m: f64) -> PyResult<(PlanExecution<'a>, Vec<PickPath>)> {
        let Some(scenario) = &plan.task.scenario else {
            return Err(bad_value(
                "a plan of a Scenario is expected: the masses of a MoveItProblem's objects are unknown",
            ));
        };
        if plan.file.waypoints.is_empty() {
            return Err(bad_value("the plan has no path, so there is nothing to execute"));
        }
        let picks = PickPath::all_of(&plan.file, &plan.task.problem).map_err(fault)?;
        let mut hand = robot_hand(&scenario.robot);
        hand.closing_force_n = self.closing_force_n.unwrap_or(hand.closing_force_n);
        let (instead, disturbance) = (self.physics, self.disturbance);
        let execution = PlanExecution { scenario, hand, instead, lift_m, disturbance, is_recorded: false };
        Ok((execution, picks))
    }

    fn execute(&self, plan: &PyPlan, lift_m: f64) -> PyResult<ExecutedPlan> {
        let (execution, picks) = self.execution(plan, lift_m)?;
        let runs = execution.run(&picks, || {}).map_err(fault)?;
        ExecutedPlan::of(&execution.scenario.id, picks.len(), &runs)
            .ok_or_else(|| bad_value("there is no target to be grasped"))
    }
}
