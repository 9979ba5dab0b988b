//! `Scenario`: a task to open, display, modify and save.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_collision::{Margins, World};
use cranny_scenario::{
    Geometry, GivenGrasps, OpenOptions, Recipe, RobotSource, Scenario, WorldConversion, built_in, catalogue,
    write_moveit_scene, write_whole_folder,
};
use cranny_task::Criterion;
use cranny_view::StandardView;
use numpy::PyArrayDyn;
use pyo3::call::PyCallArgs;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict as _, PyBytes, PyDict};

use crate::body::named_twice;
use crate::classes::{PyBody, PyCell, PyPlan, PyRobot, PyScenario};
use crate::grasping::grasp_set::PyGrasps;
use crate::handover::array::{Configurations, configuration, copied, pose_or_translation, rows, shaped};
use crate::handover::fault::{bad_value, fault};
use crate::handover::json::python_of;
use crate::handover::names::{criterion_of, geometry_of};
use crate::handover::pickled::{Made, Reduced, absolute};
use crate::handover::whole;
use crate::moveit::scene::with_scene;
use crate::picture::picture;
use crate::sensing::seen_summary::SeenSummary;

#[pymethods]
impl PyScenario {
    #[new]
    #[pyo3(signature = (what, *, criterion=None, robot=None, geometry=None, grasps=None))]
    fn new(
        py: Python<'_>,
        what: PathBuf,
        criterion: Option<&str>,
        robot: Option<PathBuf>,
        geometry: Option<&str>,
        grasps: Option<PathBuf>,
    ) -> PyResult<Self> {
        let given_grasps = GivenGrasps::of_text(grasps.as_deref().map(Path::to_string_lossy).as_deref());
        let criterion = criterion.map(criterion_of).transpose()?;
        let geometry = geometry.map(geometry_of).transpose()?;
        let options = OpenOptions { criterion, robot: robot.clone(), geometry, grasps: given_grasps.clone() };
        let text = what.to_string_lossy().into_owned();
        let scenario = py.detach(|| Scenario::open(&text, &options)).map_err(fault)?;
        // A built-in scenario is opened by its id in any folder.
        let is_built_in = built_in().any(|entry| entry.id == text);
        let what = if is_built_in { what } else { absolute(&what)? };
        let keywords = PyDict::new(py);
        keywords.set_item("criterion", criterion.map(Criterion::name))?;
        keywords.set_item("robot", robot.as_deref().map(absolute).transpose()?)?;
        keywords.set_item("geometry", geometry.map(Geometry::name))?;
        keywords.set_item(
            "grasps",
            match &given_grasps {
                GivenGrasps::File(file) => Some(absolute(file)?),
                GivenGrasps::Own | GivenGrasps::None => grasps,
            },
        )?;
        let made = Made::opened(py.get_type::<Self>().as_any(), (what,), &keywords)?;
        Ok(Self {
            scenario: Arc::new(scenario),
            robot_file: robot,
            geometry,
            given_grasps,
            goals: None,
            made,
        })
    }

    /// Creates a scenario of a robot among bodies, in the planning frame. `start`: (dof,), m or rad; None: the robot's own.
    /// `target`: the name of the body to grasp. `grasps`: grasps of the target; None: planners generate their own. Without a
    /// target, set a goal with `with_goals` or `with_grasps`. `name`: name in plans and pictures.
    #[staticmethod]
    #[pyo3(signature = (robot, bodies, *, start=None, target=None, grasps=None, name="scene"))]
    fn of<'py>(
        robot: &Bound<'py, PyRobot>,
        bodies: Vec<Bound<'py, PyBody>>,
        start: Option<&Bound<'py, PyAny>>,
        target: Option<&str>,
        grasps: Option<&Bound<'py, PyGrasps>>,
        name: &str,
    ) -> PyResult<Self> {
        let keywords = PyDict::new(robot.py());
        keywords.set_item("target", target)?;
        keywords.set_item("grasps", grasps)?;
        keywords.set_item("name", name)?;
        let all: Vec<_> = bodies.iter().map(|body| body.get().body.clone()).collect();
        let place = |name: &str| all.iter().position(|body| body.name == name);
        if let Some(name) = named_twice(&all) {
            return Err(bad_value(format!("two bodies are called '{name}'")));
        }
        let target = target
            .map(|name| place(name).ok_or_else(|| bad_value(format!("target: no body is called '{name}'"))))
            .transpose()?;
        let own_robot = robot.get().robot.clone();
        let start = match (start, own_robot.default_start()) {
            (Some(start), _) => configuration(start, "start", &own_robot)?,
            (None, Some(start)) => start.to_vec(),
            (None, None) => {
                return Err(bad_value("start: the robot has no default start; give a configuration"));
            }
        };
        keywords.set_item("start", shaped(robot.py(), start.clone(), &[start.len()])?)?;
        let bare = Scenario::bare(name.to_owned(), own_robot, World::new(all).map_err(fault)?, Vec::new());
        let scenario = Scenario {
            target,
            robot_source: robot.get().source.clone(),
            grasps: grasps.map(|grasps| grasps.get().set.clone()).unwrap_or_default(),
            has_grasp_set: grasps.is_some() || target.is_none(),
            ..bare
        };
        let made = Made::opened(&robot.py().get_type::<Self>().getattr("of")?, (robot, bodies), &keywords)?;
        Ok(Self {
            scenario: Arc::new(scenario.with_start(start).map_err(fault)?),
            robot_file: None,
            geometry: None,
            given_grasps: GivenGrasps::Own,
            goals: None,
            made,
        })
    }

    /// Opens the scenario at `path`: a folder or a packed `.zip`, never a built-in one.
    #[staticmethod]
    #[pyo3(signature = (path, *, criterion=None, robot=None, geometry=None, grasps=None))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        criterion: Option<&str>,
        robot: Option<PathBuf>,
        geometry: Option<&str>,
        grasps: Option<PathBuf>,
    ) -> PyResult<Self> {
        // `./021` is the folder, `021` the built-in scenario.
        let path = if path.is_absolute() { path } else { PathBuf::from(".").join(path) };
        Self::new(py, path, criterion, robot, geometry, grasps)
    }

    /// Converts the model of a world (MJCF, SDF or URDF) to a new folder, and opens it, as `cranny scenario from` does.
    ///
    /// `target`: body to grasp. `joints`: values (m, rad) of joints of the world, by name. `at`: x, y, z (m) and heading (degrees)
    /// of the robot's root in the world; by default at its origin, standing on the floor. `leave_out`: bodies to omit, with all
    /// that is below them. `model_path`: folders to search for models.
    #[staticmethod]
    #[pyo3(signature = (world, folder, *, robot, target, joints=None, at=None, leave_out=None, model_path=None))]
    #[allow(clippy::too_many_arguments, reason = "the keywords of the Python function")]
    fn from_world(
        py: Python<'_>,
        world: PathBuf,
        folder: PathBuf,
        robot: PathBuf,
        target: String,
        joints: Option<BTreeMap<String, f64>>,
        at: Option<[f64; 4]>,
        leave_out: Option<Vec<String>>,
        model_path: Option<Vec<PathBuf>>,
    ) -> PyResult<Self> {
        let conversion = WorldConversion {
            robot,
            target,
            joints: joints.unwrap_or_default(),
            left_out: leave_out.unwrap_or_default(),
            robot_at: at.map(|[x, y, z, degrees]| ([x, y, z], degrees.to_radians())),
            folders: model_path.unwrap_or_default(),
        };
        py.detach(|| {
            let (recipe, _) = Recipe::of_world(&world, &conversion)?;
            write_whole_folder(&folder, |folder| recipe.write_folder(folder))
        })
        .map_err(fault)?;
        Self::load(py, folder, None, None, None, None)
    }

    /// Built-in id, or the name of the folder.
    #[getter]
    fn id(&self) -> &str {
        &self.scenario.id
    }

    /// Criterion for solved tasks: "exact" or "paper".
    #[getter]
    fn criterion(&self) -> &'static str {
        self.scenario.criterion.name()
    }

    /// Robot of the scenario.
    #[getter]
    fn robot(slf: &Bound<'_, Self>) -> PyResult<PyRobot> {
        let Scenario { robot, robot_source, joint_bounds, .. } = &*slf.get().scenario;
        // Bounds of the joints are not in the robot's files.
        let source = if joint_bounds.is_empty() { robot_source.clone() } else { RobotSource::Other };
        Ok(PyRobot { robot: robot.clone(), source, made: Made::by_attribute(slf, "robot")? })
    }

    /// All bodies: obstacles, then the target, then the floor, if present.
    #[getter]
    fn world(&self) -> Vec<PyBody> {
        self.scenario.world.bodies().iter().map(PyBody::of_scene).collect()
    }

    /// Object to grasp, or None.
    #[getter]
    fn target(&self) -> Option<PyBody> {
        self.scenario.target.map(|target| PyBody::of_scene(&self.scenario.world.bodies()[target]))
    }

    /// Space that cameras have seen, if the obstacles are a map of it: a dictionary of its "region" (m), its volume that is free or
    /// inside known bodies ("free_m3"), the diameter of details that can be missed ("detail_m"), a "statement", …; else None.
    #[getter]
    fn seen<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &SeenSummary::of(&self.scenario))
    }

    /// Start configuration, (dof,), m or rad.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        shaped(py, self.scenario.start.clone(), &[self.scenario.start.len()])
    }

    /// Names of the placements of the target.
    #[getter]
    fn places(&self) -> Vec<String> {
        self.scenario.places.iter().map(|place| place.name.clone()).collect()
    }

    /// Goal regions, by name, each a dictionary as in `scenario.yaml`, in the planning frame.
    #[getter]
    fn regions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.scenario.regions)
    }

    /// Regions of the poses at which the hand is to the target as at one of its grasps, by the symmetry of the target: turned
    /// about its axis, slid along it, flipped. Each is a dictionary of the form of `goal_region` of `plan`. `grasp`: index.
    fn grasp_regions<'py>(&self, py: Python<'py>, grasp: usize) -> PyResult<Bound<'py, PyAny>> {
        let target = self.scenario.target.ok_or_else(|| bad_value("the scenario has no target"))?;
        let grasps = self.scenario.grasps.grasps();
        let chosen = grasps.get(grasp).ok_or_else(|| {
            bad_value(format!("grasp is {grasp}, but the scenario has {} grasps", grasps.len()))
        })?;
        let body = &self.scenario.world.bodies()[target];
        python_of(py, &cranny_task::grasp_regions(body, &chosen.world_from_gripper))
    }

    /// Tasks of several stages for `plan(scenario, task=…)`: name to list of dictionaries of `pick`, `move` or `place`.
    #[getter]
    fn tasks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let tasks = PyDict::new(py);
        for task in &self.scenario.tasks {
            tasks.set_item(&task.name, python_of(py, &task.stages)?)?;
        }
        Ok(tasks)
    }

    /// Grasps of the target.
    #[getter]
    fn grasps(&self) -> PyGrasps {
        PyGrasps { set: self.scenario.grasps.clone() }
    }

    /// Goal configurations of `with_goals`, (K, dof); None: a grasp is the goal.
    #[getter]
    fn goals<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        self.goals.as_ref().map(|goals| rows(py, goals, self.scenario.robot.dof())).transpose()
    }

    /// Configurations from the scenario's files that are known to reach a grasp, (K, dof); often none.
    #[getter]
    fn known_goals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        rows(py, &self.scenario.ik, self.scenario.robot.dof())
    }

    /// Returns the robot in the scenario's world, including target and floor, with margins in metres: `margin_m` between any
    /// bodies, `grasp_margin_m` between the hand and target or support, `object_margin_m` more around the target. Always exact.
    #[pyo3(signature = (*, margin_m=0.0, grasp_margin_m=0.0, object_margin_m=0.0))]
    fn cell(
        slf: &Bound<'_, Self>,
        margin_m: f64,
        grasp_margin_m: f64,
        object_margin_m: f64,
    ) -> PyResult<PyCell> {
        let margins = Margins { margin_m, grasp_margin_m, object_margin_m, tilt_rad: None };
        let names = ["margin_m", "grasp_margin_m", "object_margin_m"];
        let keywords =
            names.into_iter().zip([margin_m, grasp_margin_m, object_margin_m]).into_py_dict(slf.py())?;
        let problem = slf.get().exact_problem(margins)?;
        let cell = problem.cell().ok_or_else(|| bad_value("the scenario has no exact cell"))?.clone();
        Ok(PyCell { cell, made: Made::by_method(slf, ("cell",), Some(&keywords))? })
    }

    /// Returns the scenario with an additional obstacle.
    fn with_body<'py>(slf: &Bound<'py, Self>, body: &Bound<'py, PyBody>) -> PyResult<Self> {
        let scenario = slf.get().scenario.with_body(body.get().body.clone()).map_err(fault)?;
        Self::altered(slf, scenario, ("with_body", body))
    }

    /// Returns the scenario with an additional box of full lengths `size` (3,) in metres, centred at `pose`, (4, 4) or (3,).
    #[pyo3(signature = (name, size, *, pose=None))]
    fn with_box<'py>(
        slf: &Bound<'py, Self>,
        name: String,
        size: &Bound<'py, PyAny>,
        pose: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        let body = Bound::new(slf.py(), PyBody::r#box(slf.py(), name, size, pose)?)?;
        Self::with_body(slf, &body)
    }

    /// Returns the scenario without the body of that name, the places on it, and the tasks that name it or such a place. Without the
    /// target there are no poses to place it either.
    fn without_body(slf: &Bound<'_, Self>, name: &str) -> PyResult<Self> {
        let scenario = slf.get().scenario.without_body(name).map_err(fault)?;
        Self::altered(slf, scenario.without_lost_places(), ("without_body", name))
    }

    /// Returns the scenario with target and grasps moved by `motion` in the planning frame, (3,) in metres or (4, 4).
    fn with_object_moved<'py>(slf: &Bound<'py, Self>, motion: &Bound<'py, PyAny>) -> PyResult<Self> {
        let pose = pose_or_translation(Some(motion), "motion")?;
        let scenario = slf.get().scenario.with_target_moved(&pose).map_err(fault)?;
        Self::altered(slf, scenario, ("with_object_moved", copied(motion)?))
    }

    /// Returns the scenario with goal configurations, (dof,) or (K, dof), instead of grasps; reaching one of them solves it.
    fn with_goals<'py>(slf: &Bound<'py, Self>, goals: &Bound<'py, PyAny>) -> PyResult<Self> {
        let own = slf.get();
        let robot = &own.scenario.robot;
        let goals = Configurations::read(goals, "goals", robot)?.rows(robot.dof())?;
        let call = ("with_goals", rows(slf.py(), &goals, robot.dof())?);
        Ok(Self { goals: Some(goals), ..Self::altered(slf, (*own.scenario).clone(), call)? })
    }

    /// Returns the scenario with other grasps. Each is a pose of the gripper frame: without a target, a pose to reach.
    fn with_grasps<'py>(slf: &Bound<'py, Self>, grasps: &Bound<'py, PyGrasps>) -> PyResult<Self> {
        let scenario = slf.get().scenario.with_grasps(grasps.get().set.clone());
        Ok(Self { goals: None, ..Self::altered(slf, scenario, ("with_grasps", grasps))? })
    }

    /// Returns the scenario without a set of grasps: `plan` then generates a grasp (`plan.own_grasp`), which is verified by its
    /// contacts on the target's mesh and by whether the fingers can close on it.
    fn without_grasps(slf: &Bound<'_, Self>) -> PyResult<Self> {
        let scenario = slf.get().scenario.without_grasps();
        Ok(Self {
            given_grasps: GivenGrasps::None,
            goals: None,
            ..Self::altered(slf, scenario, ("without_grasps",))?
        })
    }

    /// Returns the scenario with the body of that name as the target. Unless it is the scenario's own target, it has no set of
    /// grasps, and `plan` generates one; its mass and friction are those of its entry in scenario.yaml. Places on that body are left
    /// out, and the tasks that name such a place.
    fn with_target(slf: &Bound<'_, Self>, name: &str) -> PyResult<Self> {
        let own = slf.get();
        let scenario = own.scenario.with_target(name).map_err(fault)?.without_lost_places();
        let is_own = own.scenario.target == scenario.target;
        let altered = Self::altered(slf, scenario, ("with_target", name))?;
        Ok(if is_own { altered } else { Self { given_grasps: GivenGrasps::None, goals: None, ..altered } })
    }

    /// Returns the scenario after the execution of `plan`, which must put down what it picks: the bodies and the robot are at
    /// their final poses. The target is the scenario's own, even if the plan moved another object.
    fn after<'py>(slf: &Bound<'py, Self>, plan: &Bound<'py, PyPlan>) -> PyResult<Self> {
        let (own, done) = (&slf.get().scenario, plan.get());
        done.file.check_joints(Path::new("the plan"), &own.robot).map_err(fault)?;
        if !done.is_valid {
            return Err(bad_value("plan: it is not valid, so the state after it is unknown"));
        }
        let scenario =
            slf.py().detach(|| done.file.scenario_after(own, &done.task.problem)).map_err(fault)?;
        Self::altered(slf, scenario, ("after", plan))
    }

    /// Returns the scenario with another start, (dof,).
    pub fn with_start<'py>(slf: &Bound<'py, Self>, start: &Bound<'py, PyAny>) -> PyResult<Self> {
        let values = configuration(start, "start", &slf.get().scenario.robot)?;
        let known = shaped(slf.py(), values.clone(), &[values.len()])?;
        let scenario = slf.get().scenario.with_start(values).map_err(fault)?;
        Self::altered(slf, scenario, ("with_start", known))
    }

    /// Returns the scenario with another criterion, "exact" or "paper".
    fn with_criterion(slf: &Bound<'_, Self>, criterion: &str) -> PyResult<Self> {
        let scenario = Scenario { criterion: criterion_of(criterion)?, ..(*slf.get().scenario).clone() };
        Self::altered(slf, scenario, ("with_criterion", criterion))
    }

    /// Writes the scenario to a new folder in Cranny's own layout, for `Scenario.load`. Its robot must be a built-in one (such as
    /// `Robot.builtin`) or that of the files of a scenario (`scenario.robot`), with the floor where it stands.
    ///
    /// Goals of `with_goals` raise ValueError, since the layout has no key for them: keep them, and call `with_goals` again after
    /// loading. `about` (title, author, licence) of the files that the scenario was read from is not written.
    fn save(&self, folder: PathBuf) -> PyResult<()> {
        if self.goals.is_some() {
            return Err(bad_value(
                "goals of with_goals cannot be saved: a scenario.yaml has no key for them (save the scenario from \
                 before with_goals, and call with_goals again after loading)",
            ));
        }
        self.scenario.write_folder(&folder).map_err(fault)
    }

    /// Writes the world and the start as a MoveIt planning scene (YAML), in the frame of the robot's root. A capsule becomes a
    /// cylinder and two spheres, the floor a box of 20 m × 20 m × 1 m below it.
    fn save_moveit_scene(&self, path: PathBuf) -> PyResult<()> {
        let Scenario { id, robot, world, start, .. } = &*self.scenario;
        write_moveit_scene(&path, id, robot, world, start).map_err(fault)
    }

    /// Returns the scenario with the collision objects of a MoveIt planning scene (YAML) instead of its obstacles and floor;
    /// robot and grasps stay. An object with the target's name replaces the target. Places on bodies that are then missing, and the
    /// tasks that name them, are left out.
    fn with_moveit_scene(slf: &Bound<'_, Self>, path: PathBuf) -> PyResult<Self> {
        let scenario = with_scene(&slf.get().scenario, &path)?.without_lost_places();
        let caller = slf.getattr("with_moveit_scene")?;
        let made = Made::opened(&caller, (absolute(&path)?,), &PyDict::new(slf.py()))?;
        Ok(Self { made, ..Self::with(slf, scenario) })
    }

    /// For files, pickles contain paths and a fingerprint of the content; unpickling raises an error if that has changed.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        slf.get().made.reduced(slf, "open it again")
    }

    /// Returns a View of the scenario for a notebook, with `plan` or the plans of its `steps` if given. `view`:
    /// "three-quarter", "front", "side" or "top"; `width` and `height` in pixels.
    #[pyo3(signature = (plan=None, *, view="three-quarter", width=640, height=480))]
    fn show<'py>(
        slf: &Bound<'py, Self>,
        plan: Option<&Bound<'py, PyAny>>,
        view: &str,
        #[pyo3(from_py_with = whole::width)] width: usize,
        #[pyo3(from_py_with = whole::height)] height: usize,
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
        let goals = self.goals.as_ref().map(|goals| format!("{} goals", goals.len()));
        let ends = goals.unwrap_or_else(|| format!("{grasps} grasps"));
        format!("<cranny.Scenario '{id}' ({}): {bodies} bodies, {ends}>", criterion.name())
    }
}

/// Size of a picture in a notebook, in pixels.
const NOTEBOOK_WIDTH: usize = 640;
const NOTEBOOK_HEIGHT: usize = 480;

impl PyScenario {
    /// Wraps the scenario that `method`, called with its argument, made from `own`.
    fn altered<'py>(
        own: &Bound<'py, Self>,
        scenario: Scenario,
        method: impl PyCallArgs<'py>,
    ) -> PyResult<Self> {
        Ok(Self { made: Made::by_method(own, method, None)?, ..Self::with(own, scenario) })
    }

    /// Wraps a scenario that was made from `own`.
    pub fn with(own: &Bound<'_, Self>, scenario: Scenario) -> Self {
        let own = own.get();
        let (robot_file, geometry) = (own.robot_file.clone(), own.geometry);
        // Grasps that were passed as arrays have no file.
        let given_grasps = if scenario.has_grasp_set && scenario.grasps != own.scenario.grasps {
            GivenGrasps::Own
        } else {
            own.given_grasps.clone()
        };
        let goals = own.goals.clone();
        Self { scenario: Arc::new(scenario), robot_file, geometry, given_grasps, goals, made: Made::UNKNOWN }
    }
}

/// Returns the ids of the built-in scenarios.
#[pyfunction]
pub fn scenario_ids() -> Vec<String> {
    catalogue().iter().map(|entry| entry.id.to_string()).collect()
}
