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

/// A problem in `MoveIt`'s YAML, as `MotionBenchMaker` publishes them: a `PlanningScene`, and a
/// `MotionPlanRequest` with goals in joint space.
#[derive(Clone, Debug)]
pub struct MoveItProblem {
    /// The stem of the scene file's name.
    pub id: String,
    /// The robot; its root frame is the planning frame.
    pub robot: Arc<Robot>,
    /// The collision objects, in the planning frame.
    pub world: World,
    /// The configuration to start from (m, rad).
    pub start: Vec<f64>,
    /// The configurations to reach, any of them (m, rad).
    pub goals: Vec<Vec<f64>>,
    /// Where the problem is not what the files say.
    pub deviations: Vec<MoveItDeviation>,
    /// Greatest speed of the gripper frame, in m/s, that the request demands.
    pub tool_speed_m_s: Option<f64>,
}

/// What `MoveIt` files leave open.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MoveItOptions {
    /// The robot's URDF. Default: `<model>_spherized.urdf`, else `<model>.urdf`, in the scene's folder, else
    /// in the folder above it, with the scene's `robot_model_name`.
    pub robot: Option<PathBuf>,
    /// The robot's SRDF. Default: beside the URDF, with its stem, else `<model>.srdf`; else that in the
    /// scene's folder or the one above it.
    pub srdf: Option<PathBuf>,
}

impl MoveItProblem {
    /// Opens a scene and a request.
    ///
    /// Every key of every message is known; what has a bearing on the problem is honoured, or refused where it holds
    /// something that is not (docs/files.md lists all).
    ///
    /// 1. The robot moves the joints of the SRDF group that the request names. A joint outside it has the value of
    ///    the start state, within its limits; one that is fixed in the URDF, or follows another, has the value that
    ///    the URDF gives. Limits of a `joint_limits.yaml` near the robot's files take precedence over those of the
    ///    URDF. Joint constraints of `path_constraints` narrow them, for the whole motion; of a continuous joint held across
    ///    a limit, the part on one side. Its constraints on positions and orientations are bounds of
    ///    the tool. Pairs of links are left unchecked as in the SRDF; the scene's
    ///    `allowed_collision_matrix` can add checks of pairs that the SRDF disables, but removes none (see
    ///    [`MoveItDeviation`]).
    /// 2. The world is the scene's collision objects, at (frame · object pose · shape pose). The planning frame
    ///    is the root link's, moved by the inverse of the floating joint of the start state, or else of the scene's
    ///    state, if there is one.
    /// 3. Start: the request's start state, and for joints that it leaves out the scene's robot state.
    /// 4. Goals: one configuration for each entry of `goal_constraints`. Tolerances are not used: it is
    ///    reached as it stands.
    ///
    /// # Errors
    /// [`ScenarioError`], with file and line where there is one; among them [`ScenarioError::Unsupported`]
    /// for what would change the problem but is not read (cones, planes, octomaps, attached objects,
    /// padding, constraints other than joint goals).
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

    /// The problem to plan for, under `exact`. There is no target, so that `margins` has one margin only.
    ///
    /// # Errors
    /// [`ScenarioError::Task`] for a margin that is none.
    pub fn problem(&self, margins: Margins) -> Result<Problem, ScenarioError> {
        let goal = Goal::Configurations(self.goals.clone());
        let (robot, world) = (self.robot.clone(), self.world.clone());
        Ok(Problem::exact(robot, world, None, self.start.clone(), goal, margins)?)
    }
}
