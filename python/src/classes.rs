//! The classes that others name: what each is made of. Their methods stand in files of their own, each beside what it needs.

use std::path::PathBuf;
use std::sync::Arc;

use cranny_collision::{Body, Cell};
use cranny_record::{PlanFile, PlanSource, Statement};
use cranny_robot::Robot;
use cranny_scenario::{Geometry, GivenGrasps, MoveItProblem, Scenario};
use cranny_solve::TaskTrajectory;
use cranny_task::Problem;
use pyo3::prelude::*;

use crate::handover::pickled::Made;

/// A thing in the world under one name, made of solids. Poses are in the planning frame, the root frame of the
/// robot: (4, 4), or (3,) for a translation in metres; without one, the thing stands at the origin. Immutable.
#[pyclass(name = "Body", module = "cranny", frozen)]
pub struct PyBody {
    pub body: Body,
    pub made: Made,
}

/// A robot in a world: is a configuration, is a whole motion free, and by how much?
///
/// Links and bodies are solids; what is nearer than 10 µm, or than a demanded margin, counts as contact. The same
/// answers as in Rust, bit for bit. Wherever `q` of shape (dof,) is taken, so is a batch (N, dof); `threads`: how
/// many cores share it, None: all. Immutable.
#[pyclass(name = "Cell", module = "cranny", frozen)]
pub struct PyCell {
    pub cell: Arc<Cell>,
    pub made: Made,
}

/// A problem in MoveIt's YAML, as MotionBenchMaker publishes them: a planning scene and a motion plan request with
/// goals in joint space. `robot` and `srdf`: files; by default those beside the scene. `plan` takes it like a
/// scenario.
#[pyclass(name = "MoveItProblem", module = "cranny", frozen)]
pub struct PyMoveItProblem {
    pub problem: Arc<MoveItProblem>,
    /// The URDF that was given instead of the scene's.
    pub robot_file: Option<PathBuf>,
    pub made: Made,
}

/// An answer: a path, its time, its proof and what the search cost. True if there is a path and it is valid.
#[pyclass(name = "Plan", module = "cranny", frozen)]
pub struct PyPlan {
    pub task: Task,
    /// As it was planned or read.
    pub file: PlanFile,
    /// The same with every figure as it was measured, which is all that its properties show.
    pub measured: PlanFile,
    /// Statements of its file that differ, and change nothing of the verdict.
    pub differs: Vec<Statement>,
    /// Keys of its file that are as stated.
    pub unjudged: Vec<&'static str>,
    pub trajectory: Option<Arc<TaskTrajectory>>,
    pub is_valid: bool,
}

/// A robot: links and the group of joints that moves them. Immutable.
///
/// `q` holds one value for each joint of the group, in the order of `joint_names`: metres for a joint that
/// slides, radians for one that turns. Poses are `root_from_link`, (4, 4) homogeneous matrices in metres.
/// Wherever `q` of shape (dof,) is taken, so is a batch (N, dof); answers then have N rows.
#[pyclass(name = "Robot", module = "cranny", frozen)]
pub struct PyRobot {
    pub robot: Arc<Robot>,
    pub made: Made,
}

/// A task: a robot, what stands around it, what it should grasp and how it may.
///
/// `Scenario("011")` is a built-in one; else `what` is a folder in Cranny's own layout or in the paper's released
/// one, or a packed `.zip`. `criterion`: "exact" or "paper" (by default what the scenario says, else "exact").
/// `robot`: the URDF of another robot. `geometry`: "scene" or "export", of a released scenario. `grasps`: a file of other
/// grasps, or "none", as `without_grasps`. Poses are in the planning frame, the root frame of the robot, in metres.
/// Immutable: what alters it gives another one.
#[pyclass(name = "Scenario", module = "cranny", frozen)]
pub struct PyScenario {
    pub scenario: Arc<Scenario>,
    /// The URDF that was given instead of the scenario's robot.
    pub robot_file: Option<PathBuf>,
    /// The geometry that was asked for.
    pub geometry: Option<Geometry>,
    /// The grasps that were asked for.
    pub given_grasps: GivenGrasps,
    /// The configurations to reach, any of them, in place of the grasps.
    pub goals: Option<Vec<Vec<f64>>>,
    pub made: Made,
}

/// A task as one of the classes gave it.
pub struct Task {
    /// What a plan says that it is of.
    pub source: PlanSource,
    pub problem: Problem,
    /// Greatest speed of the gripper frame, in m/s, that the problem demands.
    pub tool_m_s: Option<f64>,
    /// What pictures are made of; a problem of others has none.
    pub scenario: Option<Arc<Scenario>>,
    /// The scenario or problem as it was given.
    pub given: Py<PyAny>,
}
