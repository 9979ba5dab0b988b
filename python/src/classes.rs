//! Classes that several modules use. Their methods are in modules of their own.

use std::path::PathBuf;
use std::sync::Arc;

use cranny_collision::{Body, Cell};
use cranny_record::{PlanFile, PlanSource, Statement};
use cranny_robot::Robot;
use cranny_scenario::{Geometry, GivenGrasps, MoveItProblem, RobotSource, Scenario};
use cranny_solve::TaskTrajectory;
use cranny_task::Problem;
use pyo3::prelude::*;

use crate::handover::pickled::Made;

/// Rigid body in the world with a name, made of solids. Poses are in the planning frame, the root frame of the robot: (4, 4),
/// or (3,) for a translation in metres; the default is the origin. Immutable.
#[pyclass(name = "Body", module = "cranny", frozen)]
pub struct PyBody {
    pub body: Body,
    pub made: Made,
}

/// Robot in a world, for checks of configurations and whole motions, and for clearances.
///
/// Links and bodies are solids; pairs nearer than 10 µm, or than a required margin, count as contact. The results equal those
/// of Rust, bit for bit. Every `q` of shape (dof,) may also be a batch (N, dof); `threads`: number of cores that share it,
/// None: all. Immutable.
#[pyclass(name = "Cell", module = "cranny", frozen)]
pub struct PyCell {
    pub cell: Arc<Cell>,
    pub made: Made,
}

/// Problem in MoveIt's YAML, as MotionBenchMaker publishes them: a planning scene and a motion plan request with goals in joint
/// space. `robot` and `srdf`: files; by default those beside the scene. `plan` takes it like a scenario.
#[pyclass(name = "MoveItProblem", module = "cranny", frozen)]
pub struct PyMoveItProblem {
    pub problem: Arc<MoveItProblem>,
    /// URDF that was given instead of the scene's.
    pub robot_file: Option<PathBuf>,
    pub made: Made,
}

/// Result of planning: a path, its timing, its proof and the statistics of the search. True if there is a valid path.
#[pyclass(name = "Plan", module = "cranny", frozen)]
pub struct PyPlan {
    pub task: Task,
    /// Plan as it was planned or read.
    pub file: PlanFile,
    /// Plan with measured values instead of stated ones; its properties show only these.
    pub measured: PlanFile,
    /// Statements of its file that differ from the measurements without affecting the verdict.
    pub differs: Vec<Statement>,
    /// Keys of its file whose values are unverified.
    pub unjudged: Vec<&'static str>,
    pub trajectory: Option<Arc<TaskTrajectory>>,
    pub is_valid: bool,
}

/// Robot: links, and the group of joints that moves them. Immutable.
///
/// `q` contains one value for each joint of the group, in the order of `joint_names`: metres for a prismatic joint, radians for
/// a revolute one. Poses are `root_from_link`, (4, 4) homogeneous matrices in metres. Every `q` of shape (dof,) may also be a
/// batch (N, dof); results then have N rows.
#[pyclass(name = "Robot", module = "cranny", frozen)]
pub struct PyRobot {
    pub robot: Arc<Robot>,
    /// Source by which a scenario file can name it.
    pub source: RobotSource,
    pub made: Made,
}

/// Task: a robot, its surroundings, the object to grasp and its grasps.
///
/// `Scenario("011")` is a built-in one; otherwise `what` is a folder in Cranny's own layout or in the paper's released one, or
/// a packed `.zip`. `criterion`: "exact" or "paper" (by default that of the scenario, else "exact"). `robot`: the URDF of
/// another robot. `geometry`: "scene" or "export", for a released scenario. `grasps`: a file of other grasps, or "none", as
/// `without_grasps`. Poses are in the planning frame, the root frame of the robot, in metres. Immutable: methods that change it
/// return a new scenario.
#[pyclass(name = "Scenario", module = "cranny", frozen)]
pub struct PyScenario {
    pub scenario: Arc<Scenario>,
    /// URDF that was given instead of the scenario's robot.
    pub robot_file: Option<PathBuf>,
    /// Requested geometry.
    pub geometry: Option<Geometry>,
    /// Requested grasps.
    pub given_grasps: GivenGrasps,
    /// Goal configurations instead of the grasps; any of them is a goal.
    pub goals: Option<Vec<Vec<f64>>>,
    pub made: Made,
}

/// Task of one of the classes.
pub struct Task {
    /// Source that a plan states.
    pub source: PlanSource,
    pub problem: Problem,
    /// Maximum speed of the gripper frame that the problem requires, in m/s.
    pub tool_m_s: Option<f64>,
    /// Scenario for pictures; `None` for a problem from external files.
    pub scenario: Option<Arc<Scenario>>,
    /// Scenario or problem object as given.
    pub given: Py<PyAny>,
}
