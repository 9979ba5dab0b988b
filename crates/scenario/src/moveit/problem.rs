use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use cranny_collision::{Margins, World};
use cranny_file::TextFault;
use cranny_robot::{JointLimits, Location, Robot};
use cranny_task::{Goal, Problem};
use serde::Deserialize;
use serde_json::Value;

use crate::files::yaml;
use crate::moveit::base::world_from_root;
use crate::moveit::matrix::Matrix;
use crate::moveit::message_file::MessageFile;
use crate::moveit::request::Files;
use crate::moveit::robot_model::MoveItRobot;
use crate::moveit::world::bodies;
use crate::{MoveItDeviation, ScenarioError};

/// Name of a document in errors.
const DOCUMENT: &str = "request";

/// Reads a document of messages of `MoveIt` from a text in JSON or YAML, for [`MoveItProblem::of_document`].
///
/// # Errors
/// [`ScenarioError::Yaml`] with the line.
pub fn moveit_document(text: &str) -> Result<Value, ScenarioError> {
    yaml::parse(Path::new(DOCUMENT), text)
}

/// Planning problem in the YAML format of `MoveIt`, as published by `MotionBenchMaker`: a `PlanningScene`, and a
/// `MotionPlanRequest` with goals in joint space.
#[derive(Clone, Debug)]
pub struct MoveItProblem {
    /// Stem of the scene file's name; name of a scene in memory.
    pub id: String,
    /// Group of joints that the request names.
    pub group: String,
    /// Robot; its root frame is the planning frame.
    pub robot: Arc<Robot>,
    /// Limits of the joints of the group without those of path constraints (m, rad), in their order.
    pub joint_limits: Vec<JointLimits>,
    /// Collision objects, in the planning frame.
    pub world: World,
    /// Start configuration (m, rad).
    pub start: Vec<f64>,
    /// Goal configurations (m, rad); any of them may be reached.
    pub goals: Vec<Vec<f64>>,
    /// Differences between the problem and its files.
    pub deviations: Vec<MoveItDeviation>,
    /// Maximum speed of the gripper frame, in m/s, that the request specifies.
    pub tool_speed_m_s: Option<f64>,
    /// Time that the request allows for planning.
    pub allowed_time: Option<Duration>,
}

/// Options that complete `MoveIt` files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MoveItOptions {
    /// Built-in robot, folder of a robot, or URDF. Default: `<model>_spherized.urdf`, otherwise `<model>.urdf`, in the scene's
    /// folder or its parent, where `<model>` is the scene's `robot_model_name`.
    pub robot: Option<PathBuf>,
    /// SRDF of the robot. Default: beside the URDF, with its stem or as `<model>.srdf`; else near the scene, as the URDF.
    pub srdf: Option<PathBuf>,
}

impl MoveItProblem {
    /// Opens a scene and a request.
    ///
    /// Every key of every message is known; keys that affect the problem are supported, or refused if their value is not
    /// (docs/files.md lists all).
    ///
    /// 1. The robot moves the joints of the SRDF group that the request names. A joint outside it has the value of the start
    ///    state, within its limits; a joint that is fixed in the URDF, or follows another, has the value that the URDF gives.
    ///    Limits of a `joint_limits.yaml` near the robot's files take precedence over those of the URDF. Joint constraints of
    ///    `path_constraints` narrow them for the whole motion; for a continuous joint whose range crosses a limit, only the
    ///    range on one side is used. Position and orientation constraints become tool bounds. Pairs of links are unchecked as
    ///    in the SRDF; the scene's `allowed_collision_matrix` can add checks of pairs that the SRDF disables, but removes none
    ///    (see [`MoveItDeviation`]).
    /// 2. The world consists of the scene's collision objects, at (frame · object pose · shape pose). The planning frame is
    ///    that of the root link, moved by the inverse of the floating joint, if there is one, of the start state or else of the
    ///    scene's state.
    /// 3. Start: the request's start state, and for joints missing there the scene's robot state.
    /// 4. Goals: one configuration for each entry of `goal_constraints`, to be reached exactly: tolerances are not used.
    ///
    /// # Errors
    /// [`ScenarioError`], with file and line if there are any; among them [`ScenarioError::Unsupported`] for content that would
    /// change the problem but is not supported (cones, planes, octomaps with probabilities, attached objects, padding, constraints other than
    /// joint goals).
    pub fn open(scene: &Path, request: &Path, options: &MoveItOptions) -> Result<Self, ScenarioError> {
        let files = Files::new(MessageFile::read(scene)?, MessageFile::read(request)?)?;
        let id = scene.file_stem().unwrap_or(scene.as_os_str()).to_string_lossy().into_owned();
        Self::of_files(&files, &mut files.robot_files(options)?, id)
    }

    /// Reads a scene and a request in memory, `{"planning_scene": …, "motion_plan_request": …}`, for a robot whose files are
    /// known, like [`Self::open`]. Errors name the entry instead of file and line. Names of mesh files must be absolute.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn of_document(document: Value, robot: &mut MoveItRobot) -> Result<Self, ScenarioError> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields, expecting = "a mapping with planning_scene and motion_plan_request")]
        struct Document {
            planning_scene: Value,
            motion_plan_request: Value,
        }
        let Document { planning_scene, motion_plan_request } =
            serde_json::from_value(document).map_err(|fault| {
                let at = Location { file: DOCUMENT.to_owned(), line: 0 };
                ScenarioError::Yaml { at, reason: TextFault { line: 1, problem: fault.to_string() } }
            })?;
        let scene = MessageFile::of_value("planning_scene", planning_scene);
        let request = MessageFile::of_value("motion_plan_request", motion_plan_request);
        let files = Files::new(scene, request)?;
        Self::of_files(&files, robot, files.scene.name.clone().unwrap_or_default())
    }

    fn of_files(files: &Files, model: &mut MoveItRobot, id: String) -> Result<Self, ScenarioError> {
        files.refuse_what_is_not_asked()?;
        // 1.
        let mut deviations = Vec::new();
        let state = files.state(&mut deviations)?;
        let robot = files.robot(model, &state, &mut deviations)?;
        let joint_limits = robot.limits().to_vec();
        let robot = files.with_held_joints(robot)?;
        // 2.
        let world_from_root = world_from_root(&files.states(), &robot, &mut deviations)?;
        let bodies = bodies(&files.scene_file, &files.scene, &robot, &world_from_root)?;
        if bodies.is_empty() {
            deviations.push(MoveItDeviation::EmptyWorld);
        }
        let body_names: HashSet<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
        let matrix = Matrix::new(&files.scene_file, &files.scene.allowed_collision_matrix)?;
        deviations.extend(matrix.checked(&robot, &body_names));
        let tool_bounds = files.tool_bounds(&robot, &world_from_root, &mut deviations)?;
        // 3.
        let start = files.start(&robot, &state, &mut deviations)?;
        Ok(Self {
            group: files.request.group_name.value.clone(),
            tool_speed_m_s: files.tool_speed_m_s(&robot)?,
            allowed_time: files.allowed_time()?,
            id,
            world: World::new(bodies)?.with_tool_bounds(tool_bounds)?,
            // 4.
            goals: files.goals(&robot, &start, &mut deviations)?,
            start,
            joint_limits,
            robot,
            deviations,
        })
    }

    /// Returns the planning problem, under `exact`. It has no target, so `margins` contains one margin only.
    ///
    /// # Errors
    /// [`ScenarioError::Task`] for an invalid margin.
    pub fn problem(&self, margins: Margins) -> Result<Problem, ScenarioError> {
        let goal = Goal::Configurations(self.goals.clone());
        let (robot, world) = (self.robot.clone(), self.world.clone());
        Ok(Problem::exact(robot, world, None, self.start.clone(), goal, margins)?)
    }
}
