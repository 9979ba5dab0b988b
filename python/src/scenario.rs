//! `Scenario`: a task, opened, looked at, altered and saved.

use std::path::PathBuf;
use std::sync::Arc;

use cranny_collision::World;
use cranny_plan::{Criterion, Problem, Validity};
use cranny_scenario::{Demands, OpenOptions, Scenario, catalogue, write_moveit_scene};
use cranny_view::StandardView;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::array::{configuration, pose_or_translation, rows, shaped};
use crate::body::PyBody;
use crate::cell::PyCell;
use crate::fault::{bad_value, fault};
use crate::grasp_set::PyGrasps;
use crate::picture::picture;
use crate::plan::PyPlan;
use crate::robot::PyRobot;

/// A task: a robot, what stands around it, what it should grasp and how it may.
///
/// `Scenario("011")` is a built-in one; else `what` is a folder in Cranny's own layout or in the paper's released
/// one, or a packed `.zip`. `criterion`: "exact" or "paper" (by default what the scenario says, else "exact").
/// `robot`: the URDF of another robot. Poses are in the planning frame, the root frame of the robot, in metres.
/// Immutable: what alters it gives another one.
#[pyclass(name = "Scenario", module = "cranny", frozen)]
pub struct PyScenario {
    pub scenario: Arc<Scenario>,
    /// The URDF that was given instead of the scenario's robot.
    pub robot_file: Option<PathBuf>,
}

#[pymethods]
impl PyScenario {
    #[new]
    #[pyo3(signature = (what, *, criterion=None, robot=None))]
    fn new(py: Python<'_>, what: PathBuf, criterion: Option<&str>, robot: Option<PathBuf>) -> PyResult<Self> {
        let criterion = criterion.map(criterion_of).transpose()?;
        let options = OpenOptions { criterion, robot: robot.clone(), geometry: None };
        let what = what.to_string_lossy().into_owned();
        let scenario = py.detach(|| Scenario::open(&what, &options)).map_err(fault)?;
        Ok(Self { scenario: Arc::new(scenario), robot_file: robot })
    }

    /// Opens the scenario at `path`: a folder or a packed `.zip`, never a built-in one.
    #[staticmethod]
    #[pyo3(signature = (path, *, criterion=None, robot=None))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        criterion: Option<&str>,
        robot: Option<PathBuf>,
    ) -> PyResult<Self> {
        // `./021` is the folder, `021` the built-in scenario.
        let path = if path.is_absolute() { path } else { PathBuf::from(".").join(path) };
        Self::new(py, path, criterion, robot)
    }

    /// The built-in id, or the name of the folder.
    #[getter]
    fn id(&self) -> &str {
        &self.scenario.id
    }

    /// What counts as solved: "exact" or "paper".
    #[getter]
    fn criterion(&self) -> &'static str {
        self.scenario.criterion.name()
    }

    /// The robot.
    #[getter]
    fn robot(&self) -> PyRobot {
        PyRobot { robot: self.scenario.robot.clone() }
    }

    /// All bodies: obstacles, then the target, then the floor, as far as there are.
    #[getter]
    fn world(&self) -> Vec<PyBody> {
        self.scenario.world.bodies().iter().map(|body| PyBody { body: body.clone() }).collect()
    }

    /// The object that is to be grasped, if there is one.
    #[getter]
    fn target(&self) -> Option<PyBody> {
        self.scenario.target.map(|target| PyBody { body: self.scenario.world.bodies()[target].clone() })
    }

    /// The configuration to start from, (dof,), m or rad.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        shaped(py, self.scenario.start.clone(), &[self.scenario.start.len()])
    }

    /// How the target can be grasped.
    #[getter]
    fn grasps(&self) -> PyGrasps {
        PyGrasps { set: self.scenario.grasps.clone() }
    }

    /// Configurations that are known to reach a grasp, (K, dof), from the scenario's files; often none.
    #[getter]
    fn known_goals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        rows(py, &self.scenario.ik, self.scenario.robot.dof())
    }

    /// The robot in the scenario's world, target and floor included, with the demanded margins in metres: `margin_m`
    /// between any two things, `grasp_margin_m` between hand and fingers and what they grasp or it rests on.
    /// Under the "paper" criterion too, it is the exact one.
    #[pyo3(signature = (*, margin_m=0.0, grasp_margin_m=0.0))]
    fn cell(&self, margin_m: f64, grasp_margin_m: f64) -> PyResult<PyCell> {
        let exact = Scenario { criterion: Criterion::Exact, ..(*self.scenario).clone() };
        let problem = exact.problem(&Demands { margin_m, grasp_margin_m }).map_err(fault)?;
        match problem.validity {
            Validity::Exact(cell) => Ok(PyCell { cell }),
            Validity::Paper { .. } => Err(bad_value("the scenario has no exact cell")),
        }
    }

    /// The same scenario with one obstacle more.
    fn with_body(&self, body: &PyBody) -> PyResult<Self> {
        self.altered(self.scenario.with_body(body.body.clone()).map_err(fault)?)
    }

    /// The same scenario with a box of full lengths `size` (3,) in metres more, its middle at `pose`, (4, 4) or
    /// (3,).
    #[pyo3(signature = (name, size, pose=None))]
    fn with_box(
        &self,
        name: String,
        size: &Bound<'_, PyAny>,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        self.with_body(&PyBody::r#box(name, size, pose)?)
    }

    /// The same scenario without the body of that name.
    fn without_body(&self, name: &str) -> PyResult<Self> {
        self.altered(self.scenario.without_body(name).map_err(fault)?)
    }

    /// The same scenario with the object moved by `motion`, and its grasps with it: (3,) a shift in metres, or
    /// (4, 4) a rigid motion, both of the planning frame.
    fn with_object_moved(&self, motion: &Bound<'_, PyAny>) -> PyResult<Self> {
        let motion = pose_or_translation(Some(motion), "motion")?;
        self.altered(self.scenario.with_target_moved(&motion).map_err(fault)?)
    }

    /// The same scenario with other grasps.
    fn with_grasps(&self, grasps: &PyGrasps) -> PyResult<Self> {
        self.altered(self.scenario.with_grasps(grasps.set.clone()))
    }

    /// The same scenario from another start, (dof,).
    fn with_start(&self, start: &Bound<'_, PyAny>) -> PyResult<Self> {
        let start = configuration(start, "start", &self.scenario.robot)?;
        self.altered(self.scenario.with_start(start).map_err(fault)?)
    }

    /// The same scenario under another criterion, "exact" or "paper".
    fn with_criterion(&self, criterion: &str) -> PyResult<Self> {
        let criterion = criterion_of(criterion)?;
        self.altered(Scenario { criterion, ..(*self.scenario).clone() })
    }

    /// Writes the scenario as a folder of Cranny's own layout, which is made; `Scenario.load` reads it. For the
    /// built-in robot, on its floor.
    fn save(&self, folder: PathBuf) -> PyResult<()> {
        self.scenario.write_folder(&folder).map_err(fault)
    }

    /// Writes the world and the start as a MoveIt planning scene (YAML), in the frame of the robot's root. A capsule
    /// becomes a cylinder and two spheres, the floor a box of 20 m × 20 m × 1 m below it.
    fn save_moveit_scene(&self, path: PathBuf) -> PyResult<()> {
        let Scenario { id, robot, world, start, .. } = &*self.scenario;
        write_moveit_scene(&path, id, robot, world, start).map_err(fault)
    }

    /// The same robot, target and grasps among the collision objects of a MoveIt planning scene (YAML), in place of
    /// the obstacles and the floor; an object of the target's name is the target.
    fn with_moveit_scene(&self, path: PathBuf) -> PyResult<Self> {
        let read = cranny_scenario::read_moveit_scene(&path, &self.scenario.robot).map_err(fault)?;
        let target = self.scenario.target.map(|target| &self.scenario.world.bodies()[target]);
        let mut bodies = read.bodies().to_vec();
        let place = target.map(|target| {
            bodies.iter().position(|body| body.name == target.name).unwrap_or_else(|| {
                bodies.push(target.clone());
                bodies.len() - 1
            })
        });
        let world = World::new(bodies).map_err(fault)?;
        self.altered(Scenario { world, target: place, export: None, ..(*self.scenario).clone() })
    }

    /// What a notebook shows of the scenario, with a plan where one is given: a View. `view`: "three-quarter",
    /// "front", "side" or "top"; `width` and `height` in points.
    #[pyo3(signature = (plan=None, *, view="three-quarter", width=640, height=480))]
    fn show<'py>(
        slf: &Bound<'py, Self>,
        plan: Option<&Bound<'py, PyPlan>>,
        view: &str,
        width: usize,
        height: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let keywords = PyDict::new(py);
        keywords.set_item("view", view)?;
        keywords.set_item("width", width)?;
        keywords.set_item("height", height)?;
        py.import("cranny.notebook")?.getattr("View")?.call((slf, plan), Some(&keywords))
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        picture(py, self, None, StandardView::ThreeQuarter.name(), NOTEBOOK_WIDTH, NOTEBOOK_HEIGHT)
    }

    fn __repr__(&self) -> String {
        let Scenario { id, criterion, world, grasps, .. } = &*self.scenario;
        let (bodies, grasps) = (world.bodies().len(), grasps.len());
        format!("<cranny.Scenario '{id}' ({}): {bodies} bodies, {grasps} grasps>", criterion.name())
    }
}

/// A picture in a notebook, in points.
const NOTEBOOK_WIDTH: usize = 640;
const NOTEBOOK_HEIGHT: usize = 480;

impl PyScenario {
    #[allow(clippy::unnecessary_wraps)] // The tail of methods that can fail.
    fn altered(&self, scenario: Scenario) -> PyResult<Self> {
        Ok(Self { scenario: Arc::new(scenario), robot_file: self.robot_file.clone() })
    }

    /// The problem to plan for.
    pub fn problem(&self, demands: &Demands) -> PyResult<Problem> {
        self.scenario.problem(demands).map_err(fault)
    }
}

/// Ids of the built-in scenarios.
#[pyfunction]
pub fn scenario_ids() -> Vec<String> {
    catalogue().iter().map(|entry| entry.id.to_string()).collect()
}

/// The criterion of that name.
pub fn criterion_of(name: &str) -> PyResult<Criterion> {
    [Criterion::Exact, Criterion::Paper]
        .into_iter()
        .find(|criterion| criterion.name() == name)
        .ok_or_else(|| bad_value(format!("there is no criterion '{name}' (there are: exact, paper)")))
}
