use std::collections::HashSet;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_collision::{Margins, World};
use cranny_plan::{Goal, Problem};
use cranny_robot::Robot;

use crate::ScenarioError;
use crate::files::yaml;
use crate::moveit::file::RowEntry;
use crate::moveit::request::Files;
use crate::moveit::world::{MessageFile, bodies};

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

/// Where a [`MoveItProblem`] is not what its files say.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MoveItDeviation {
    /// A joint outside the group is asked to stand beyond its limits, and stands at the limit.
    HeldAtLimit {
        /// The joint.
        joint: String,
        /// The value in the files, in metres or radians.
        requested: f64,
        /// The value taken instead.
        held: f64,
    },
    /// The scene lets two things touch that the robot's SRDF does not name; they are checked all the same.
    AllowedPairChecked {
        /// A link.
        first: String,
        /// Another link, or an object.
        second: String,
    },
}

impl fmt::Display for MoveItDeviation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::HeldAtLimit { joint, requested, held } => {
                write!(formatter, "joint '{joint}' is held at its limit {held} instead of {requested}")
            }
            Self::AllowedPairChecked { first, second } => {
                write!(formatter, "'{first}' may touch '{second}' in the scene, but not here")
            }
        }
    }
}

impl MoveItProblem {
    /// Opens a scene and a request.
    ///
    /// 1. The robot moves the joints of the SRDF group that the request names. A joint outside it stands
    ///    where the start state puts it, within its limits; one that is fixed in the URDF, or follows
    ///    another, stands where the URDF says. Pairs of links are left unchecked as in the SRDF; the scene's
    ///    `allowed_collision_matrix` lifts no further check (see [`MoveItDeviation`]).
    /// 2. The world is the scene's collision objects, at (frame · object pose · shape pose). The frame
    ///    `world` is the root link's, moved by the inverse of the start state's floating joint if there is
    ///    one.
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
            scene: yaml::read_argument(scene)?,
            request: yaml::read_argument(request)?,
        };
        // 1.
        let state = files.state()?;
        let mut deviations = Vec::new();
        let robot = files.robot(options, &state, &mut deviations)?;
        // 2.
        let bodies = bodies(scene, &files.scene, &robot, &files.world_from_root()?)?;
        let body_names: HashSet<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
        deviations.extend(allowed_pairs_checked(&files, &robot, &body_names));
        Ok(Self {
            id: scene.file_stem().unwrap_or(scene.as_os_str()).to_string_lossy().into_owned(),
            world: World::new(bodies)?,
            // 3.
            start: files.start(&robot, &state)?,
            // 4.
            goals: files.goals(&robot)?,
            robot,
            deviations,
        })
    }

    /// The problem to plan for, under `exact`. There is no target, so that `margins` has one margin only.
    ///
    /// # Errors
    /// [`ScenarioError::Plan`] for a margin that is none.
    pub fn problem(&self, margins: Margins) -> Result<Problem, ScenarioError> {
        let goal = Goal::Configurations(self.goals.clone());
        let (robot, world) = (self.robot.clone(), self.world.clone());
        Ok(Problem::exact(robot, world, None, self.start.clone(), goal, margins)?)
    }
}

/// The pairs that the scene lets touch and the robot does not, a link first.
fn allowed_pairs_checked(files: &Files<'_>, robot: &Robot, bodies: &HashSet<&str>) -> Vec<MoveItDeviation> {
    let matrix = &files.scene.allowed_collision_matrix;
    let mut pairs = Vec::new();
    for (first, (first_name, row)) in matrix.entry_names.iter().zip(&matrix.entry_values).enumerate() {
        let (RowEntry::List(row) | RowEntry::Message { enabled: row }) = row;
        for (second_name, _) in matrix.entry_names.iter().zip(row).take(first).filter(|(_, may)| **may) {
            let is_checked = match (robot.link_index(first_name), robot.link_index(second_name)) {
                (Some(a), Some(b)) => {
                    let pair = (a.min(b), a.max(b));
                    // Both are sorted.
                    robot.disabled_pairs().binary_search(&pair).is_err()
                        && robot.adjacent_pairs().binary_search(&pair).is_err()
                }
                (Some(_), None) => bodies.contains(second_name.as_str()),
                (None, Some(_)) => bodies.contains(first_name.as_str()),
                (None, None) => false,
            };
            if is_checked {
                let (first, second) = match robot.link_index(first_name) {
                    Some(_) => (first_name.clone(), second_name.clone()),
                    None => (second_name.clone(), first_name.clone()),
                };
                pairs.push(MoveItDeviation::AllowedPairChecked { first, second });
            }
        }
    }
    pairs
}
