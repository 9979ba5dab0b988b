//! `cranny.moveit.Planner`: MoveIt's requests and responses as dictionaries.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use cranny_record::{MoveItPlanner, MoveItSettings};
use cranny_scenario::moveit_document;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::handover::fault::{bad_type, fault};
use crate::handover::interrupt::InterruptObserver;
use crate::handover::json::python_of;
use crate::handover::pickled::{Made, Reduced, absolute};
use crate::planning::seconds;

/// Planner of MoveIt's requests for one robot: a built-in one, the folder of one, or a URDF; `srdf`: a file, None: that beside
/// the URDF. `margin_m`: clearance (m) that every check and proof requires. `rate`: sample rate of trajectories in Hz.
/// `time_limit_s`: maximum time (s) of a search; a request may allow less.
#[pyclass(name = "Planner", module = "cranny.moveit", frozen)]
pub struct PyMoveItPlanner {
    planner: Mutex<MoveItPlanner>,
    robot_name: String,
    groups: Vec<String>,
    made: Made,
}

#[pymethods]
impl PyMoveItPlanner {
    #[new]
    #[pyo3(signature = (robot, *, srdf=None, margin_m=0.0, rate=100.0, time_limit_s=30.0))]
    fn new(
        py: Python<'_>,
        robot: PathBuf,
        srdf: Option<PathBuf>,
        margin_m: f64,
        rate: f64,
        time_limit_s: f64,
    ) -> PyResult<Self> {
        let most_time = seconds("time_limit_s", time_limit_s)?;
        let settings = MoveItSettings { most_time, rate_hz: rate, margin_m };
        let planner = MoveItPlanner::open(&robot, srdf.as_deref(), settings).map_err(fault)?;
        let keywords = PyDict::new(py);
        keywords.set_item("srdf", srdf.as_deref().map(absolute).transpose()?)?;
        keywords.set_item("margin_m", margin_m)?;
        keywords.set_item("rate", rate)?;
        keywords.set_item("time_limit_s", time_limit_s)?;
        // The name of a built-in robot is no path.
        let named = if robot.exists() { absolute(&robot)? } else { robot };
        let made = Made::opened(py.get_type::<Self>().as_any(), (named,), &keywords)?;
        let groups = planner.groups().into_iter().map(str::to_owned).collect();
        Ok(Self { robot_name: planner.robot_name().to_owned(), groups, planner: Mutex::new(planner), made })
    }

    /// Name of the robot.
    #[getter]
    fn robot_name(&self) -> &str {
        &self.robot_name
    }

    /// Names of the groups of joints in the SRDF, one of which a request names.
    #[getter]
    fn groups(&self) -> Vec<String> {
        self.groups.clone()
    }

    /// Plans `{"planning_scene": ..., "motion_plan_request": ...}`, messages of moveit_msgs as dictionaries, and returns
    /// `{"motion_plan_response": ..., "cranny": ...}`: a `moveit_msgs/MotionPlanResponse`, and what was proven.
    ///
    /// A search without a path is a response whose `error_code` states it. A malformed request raises CrannyError, which names
    /// the entry. Requests from several threads are planned one after the other.
    fn plan<'py>(&self, py: Python<'py>, request: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let keywords = PyDict::new(py);
        keywords.set_item("ensure_ascii", false)?;
        let text: String = py
            .import("json")?
            .call_method("dumps", (request,), Some(&keywords))
            .map_err(|reason| {
                bad_type(format!("request: a dictionary of plain values is expected ({reason})"))
            })?
            .extract()?;
        let mut observer = InterruptObserver::new();
        let planned = py.detach(|| {
            let document = moveit_document(&text).map_err(fault)?;
            let mut planner = self.planner.lock().unwrap_or_else(PoisonError::into_inner);
            planner.plan(document, &mut observer).map_err(fault)
        });
        // Ctrl-C takes precedence over the result of the search.
        observer.result()?;
        python_of(py, &planned?)
    }

    /// Pickled as a Robot is.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        slf.get().made.reduced(slf, "open it again")
    }

    fn __repr__(&self) -> String {
        format!("<cranny.moveit.Planner of '{}': groups {}>", self.robot_name, self.groups.join(", "))
    }
}
