use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_collision::{Margins, World};
use cranny_robot::Robot;
use cranny_task::{Goal, Problem};

use crate::moveit::base::world_from_root;
use crate::moveit::form::{read_request, read_scene};
use crate::moveit::matrix::Matrix;
use crate::moveit::message_file::MessageFile;
use crate::moveit::request::Files;
use crate::moveit::world::bodies;
use crate::{MoveItDeviation, ScenarioError};

/// Planning problem in the YAML format of `MoveIt`, as published by `MotionBenchMaker`: a `PlanningScene`, and a
/// `MotionPlanRequest` with goals in joint space.
#[derive(Clone, Debug)]
pub struct MoveItProblem {
    /// Stem of the scene file's name.
    pub id: String,
    /// Robot; its root frame is the planning frame.
    pub robot: Arc<Robot>,
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
}

/// Options that complete `MoveIt` files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MoveItOptions {
    /// URDF of the robot. Default: `<model>_spherized.urdf`, otherwise `<model>.urdf`, in the scene's folder or its parent,
    /// where `<model>` is the scene's `robot_model_name`.
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
    /// change the problem but is not supported (cones, planes, octomaps, attached objects, padding, constraints other than
    /// joint goals).
    pub fn open(scene: &Path, request: &Path, options: &MoveItOptions) -> Result<Self, ScenarioError> {
        let files = Files {
            scene_file: MessageFile { path: scene },
            request_file: MessageFile { path: request },
            scene: read_scene(scene)?,
            request: read_request(request)?,
        };
        files.refuse_what_is_not_asked()?;
        // 1.
        let mut deviations = Vec::new();
        let state = files.state(&mut deviations)?;
        let robot = files.with_held_joints(files.robot(options, &state, &mut deviations)?)?;
        // 2.
        let world_from_root = world_from_root(&files.states(), &robot, &mut deviations)?;
        let bodies = bodies(scene, &files.scene, &robot, &world_from_root)?;
        if bodies.is_empty() {
            deviations.push(MoveItDeviation::EmptyWorld);
        }
        let body_names: HashSet<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
        let matrix = Matrix::new(&files.scene_file, &files.scene.allowed_collision_matrix)?;
        deviations.extend(matrix.checked(&robot, &body_names));
        let tool_bounds = files.tool_bounds(&robot, &world_from_root, &mut deviations)?;
        Ok(Self {
            tool_speed_m_s: files.tool_speed_m_s(&robot)?,
            id: scene.file_stem().unwrap_or(scene.as_os_str()).to_string_lossy().into_owned(),
            world: World::new(bodies)?.with_tool_bounds(tool_bounds)?,
            // 3.
            start: files.start(&robot, &state, &mut deviations)?,
            // 4.
            goals: files.goals(&robot, &mut deviations)?,
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
