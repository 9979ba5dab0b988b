//! `simulate_grasps`: grasps of a scenario in physics.

use std::path::PathBuf;
use std::sync::Mutex;

use cranny_plan::robot_hand;
use cranny_scenario::{TargetPhysics, read_gripper};
use cranny_sim::{GraspRow, GraspTest};
use pyo3::prelude::*;

use crate::fault::{bad_value, fault};
use crate::grasp_set::PyGrasps;
use crate::interrupt::Interrupt;
use crate::json::python_of;
use crate::scenario::PyScenario;
use crate::whole;

/// More trials of a grasp than this are a mistake.
const MOST_TRIALS: usize = 10_000;

/// Tries grasps of a scenario's target in physics, on all cores: the hand alone closes, lifts and shakes. One dictionary
/// for each grasp, with the keys of `cranny simulate grasps --json`: grasp, outcome ("held", "slipped", "dropped",
/// "never-closed", "knocked-away"), translation_error_m, rotation_error_rad, held_s, contact_force_n, score, and with
/// `trials` also robust, a dictionary of trials, held and score: each grasp is then tried so many times more with
/// everything a little wrong, the same for all grasps; `seed` draws others.
///
/// `grasps`: in the planning frame; by default the scenario's own. `support_only`: of what stands around only what
/// carries the target. `gripper`: a YAML file; by default the hand of the scenario's robot. `mass_kg`, `friction` and
/// `closing_force_n` go before what files say.
#[pyfunction]
#[pyo3(
    signature = (scenario, grasps=None, *, support_only=false, gripper=None, mass_kg=None, friction=None,
        closing_force_n=None, trials=0, seed=0)
)]
#[allow(clippy::too_many_arguments)] // The keywords of the Python function.
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
        return Err(bad_value(format!("trials is {trials}, but at most {MOST_TRIALS} make sense")));
    }
    let scenario = &scenario.get().scenario;
    let mut hand = match gripper {
        Some(path) => read_gripper(&path).map_err(fault)?,
        None => robot_hand(&scenario.robot),
    };
    hand.closing_force_n = closing_force_n.unwrap_or(hand.closing_force_n);
    let grasps = grasps.map_or_else(|| scenario.grasps.clone(), |grasps| grasps.get().set.clone());
    let instead = TargetPhysics { mass_kg, friction };
    let interrupt = Mutex::new(Interrupt::new());
    let rows = py.detach(|| -> PyResult<Vec<GraspRow>> {
        let test = GraspTest::of_scenario(scenario, &hand, &instead, support_only).map_err(fault)?;
        let all: Vec<usize> = (0..grasps.len()).collect();
        let stop = || interrupt.lock().is_ok_and(|mut interrupt| interrupt.asks());
        Ok(test.rows(grasps.grasps(), &all, (trials, seed), &|| {}, &stop))
    });
    if let Ok(interrupt) = interrupt.into_inner() {
        interrupt.result()?;
    }
    python_of(py, &rows?)
}
