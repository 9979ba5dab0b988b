//! `MoveItProblem`: a planning scene and a request of MoveIt.

use std::path::PathBuf;
use std::sync::Arc;

use cranny_collision::Margins;
use cranny_scenario::{MoveItOptions, MoveItProblem, RobotSource};
use cranny_task::Problem;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::classes::{PyBody, PyCell, PyMoveItProblem, PyRobot};
use crate::handover::array::{rows, shaped};
use crate::handover::fault::{bad_value, fault};
use crate::handover::pickled::{Made, Reduced, absolute};

#[pymethods]
impl PyMoveItProblem {
    #[new]
    #[pyo3(signature = (scene, request, *, robot=None, srdf=None))]
    fn new(
        py: Python<'_>,
        scene: PathBuf,
        request: PathBuf,
        robot: Option<PathBuf>,
        srdf: Option<PathBuf>,
    ) -> PyResult<Self> {
        let options = MoveItOptions { robot, srdf };
        let problem = py.detach(|| MoveItProblem::open(&scene, &request, &options)).map_err(fault)?;
        let keywords = PyDict::new(py);
        keywords.set_item("robot", options.robot.as_deref().map(absolute).transpose()?)?;
        keywords.set_item("srdf", options.srdf.as_deref().map(absolute).transpose()?)?;
        let files = (absolute(&scene)?, absolute(&request)?);
        let made = Made::opened(py.get_type::<Self>().as_any(), files, &keywords)?;
        Ok(Self { problem: Arc::new(problem), robot_file: options.robot, made })
    }

    /// Stem of the scene file's name.
    #[getter]
    fn id(&self) -> &str {
        &self.problem.id
    }

    /// Robot of the problem.
    #[getter]
    fn robot(slf: &Bound<'_, Self>) -> PyResult<PyRobot> {
        let made = Made::by_attribute(slf, "robot")?;
        Ok(PyRobot { robot: slf.get().problem.robot.clone(), source: RobotSource::Other, made })
    }

    /// Collision objects, in the root frame of the robot.
    #[getter]
    fn world(&self) -> Vec<PyBody> {
        self.problem.world.bodies().iter().map(PyBody::of_scene).collect()
    }

    /// Start configuration, (dof,), m or rad.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        shaped(py, self.problem.start.clone(), &[self.problem.start.len()])
    }

    /// Goal configurations, (K, dof); any of them is a goal.
    #[getter]
    fn goals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        rows(py, &self.problem.goals, self.problem.robot.dof())
    }

    /// Deviations of the problem from its files, in sentences.
    #[getter]
    fn deviations(&self) -> Vec<String> {
        self.problem.deviations.iter().map(ToString::to_string).collect()
    }

    /// Returns the robot among the collision objects, with the clearance `margin_m` (m) required between any two bodies.
    #[pyo3(signature = (*, margin_m=0.0))]
    fn cell(slf: &Bound<'_, Self>, margin_m: f64) -> PyResult<PyCell> {
        let keywords = PyDict::new(slf.py());
        keywords.set_item("margin_m", margin_m)?;
        let cell = slf
            .get()
            .problem(Margins { margin_m, grasp_margin_m: 0.0, ..Margins::default() })?
            .cell()
            .ok_or_else(|| bad_value("the problem has no exact cell"))?
            .clone();
        Ok(PyCell { cell, made: Made::by_method(slf, ("cell",), Some(&keywords))? })
    }

    /// Pickled as a Scenario is.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        slf.get().made.reduced(slf, "open it again")
    }

    fn __repr__(&self) -> String {
        let (id, bodies) = (&self.problem.id, self.problem.world.bodies().len());
        format!("<cranny.MoveItProblem '{id}': {bodies} bodies, {} goals>", self.problem.goals.len())
    }
}

impl PyMoveItProblem {
    pub fn problem(&self, margins: Margins) -> PyResult<Problem> {
        self.problem.problem(margins).map_err(fault)
    }
}
