//! `MoveItProblem`: a scene and a request of others.

use std::path::PathBuf;
use std::sync::Arc;

use cranny_plan::{Problem, Validity};
use cranny_scenario::{Demands, MoveItOptions, MoveItProblem};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::array::{rows, shaped};
use crate::body::PyBody;
use crate::cell::PyCell;
use crate::fault::{bad_value, fault};
use crate::robot::PyRobot;

/// A problem in MoveIt's YAML, as MotionBenchMaker publishes them: a planning scene and a motion plan request with
/// goals in joint space. `robot` and `srdf`: files; by default those beside the scene. `plan` takes it like a
/// scenario.
#[pyclass(name = "MoveItProblem", module = "cranny", frozen)]
pub struct PyMoveItProblem {
    pub problem: Arc<MoveItProblem>,
}

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
        Ok(Self { problem: Arc::new(problem) })
    }

    /// The stem of the scene file's name.
    #[getter]
    fn id(&self) -> &str {
        &self.problem.id
    }

    /// The robot.
    #[getter]
    fn robot(&self) -> PyRobot {
        PyRobot { robot: self.problem.robot.clone() }
    }

    /// The collision objects, in the root frame of the robot.
    #[getter]
    fn world(&self) -> Vec<PyBody> {
        self.problem.world.bodies().iter().map(|body| PyBody { body: body.clone() }).collect()
    }

    /// The configuration to start from, (dof,), m or rad.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        shaped(py, self.problem.start.clone(), &[self.problem.start.len()])
    }

    /// The configurations to reach, any of them: (K, dof).
    #[getter]
    fn goals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        rows(py, &self.problem.goals, self.problem.robot.dof())
    }

    /// Where the problem is not what the files say, in sentences.
    #[getter]
    fn deviations(&self) -> Vec<String> {
        self.problem.deviations.iter().map(ToString::to_string).collect()
    }

    /// The robot among the collision objects, with `margin_m` (m) demanded between any two things.
    #[pyo3(signature = (*, margin_m=0.0))]
    fn cell(&self, margin_m: f64) -> PyResult<PyCell> {
        match self.problem(&Demands { margin_m, grasp_margin_m: 0.0 })?.validity {
            Validity::Exact(cell) => Ok(PyCell { cell }),
            Validity::Paper { .. } => Err(bad_value("the problem has no exact cell")),
        }
    }

    fn __repr__(&self) -> String {
        let (id, bodies) = (&self.problem.id, self.problem.world.bodies().len());
        format!("<cranny.MoveItProblem '{id}': {bodies} bodies, {} goals>", self.problem.goals.len())
    }
}

impl PyMoveItProblem {
    pub fn problem(&self, demands: &Demands) -> PyResult<Problem> {
        self.problem.problem(demands).map_err(fault)
    }
}
