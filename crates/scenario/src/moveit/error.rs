use std::path::PathBuf;

use cranny_file::distinct;
use cranny_robot::Location;

/// Errors of a `MoveIt` scene, a request, or their robot. Each message is self-contained and names file and line, if any.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MoveItError {
    /// A `MoveIt` joint state does not give each joint one position.
    #[error("{at}: the joint state has {names} names, but {values} {kind}")]
    JointState {
        /// Location in the file.
        at: Location,
        /// Number of joint names.
        names: usize,
        /// `positions` or `transforms`.
        kind: &'static str,
        /// Number of these values.
        values: usize,
    },
    /// A `MoveIt` scene has no world.
    #[error(
        "{}: no world: the scene has no 'world' (one without objects is `world: {{collision_objects: []}}`)",
        path.display()
    )]
    NoWorld {
        /// The scene file.
        path: PathBuf,
    },
    /// A file does not contain exactly one message.
    #[error("{}: a list of {actual} messages, but one is read (give that alone)", path.display())]
    NotOneMessage {
        /// The file.
        path: PathBuf,
        /// Number of messages in it.
        actual: usize,
    },
    /// A `.scene` file is malformed.
    #[error("{at}: expected {expected}, not '{found}'")]
    SceneText {
        /// Location in the file.
        at: Location,
        /// Expected content.
        expected: &'static str,
        /// Actual content.
        found: String,
    },
    /// An `allowed_collision_matrix` is malformed.
    #[error(
        "{at}: the matrix of allowed collisions must be symmetric, with {names} rows of {names} values for its {names} \
         names, and a value for each default"
    )]
    Matrix {
        /// Location in the file.
        at: Location,
        /// Number of its names.
        names: usize,
    },
    /// A fixed transform contradicts the known pose of a frame.
    #[error("{at}: frame '{frame}' is already known, with another pose (leave the transform out)")]
    FrameTwice {
        /// Location in the file.
        at: Location,
        /// Name of the frame.
        frame: String,
    },
    /// The pose of the robot's base is given for a joint that is not virtual.
    #[error("{at}: '{joint}' is no virtual joint of the robot's SRDF (it has: {known})")]
    NoVirtualJoint {
        /// Location in the file.
        at: Location,
        /// Name of the joint.
        joint: String,
        /// Names of the virtual joints.
        known: String,
    },
    /// A goal gives another value for a joint that is fixed or follows others.
    #[error(
        "{at}: the goal asks joint '{joint}' to be at {}, but it does not move freely, and is at {} there",
        distinct([*asked, *actual], 4)[0],
        distinct([*asked, *actual], 4)[1]
    )]
    GoalElsewhere {
        /// Location in the file.
        at: Location,
        /// Name of the joint.
        joint: String,
        /// Value in the goal, in metres or radians.
        asked: f64,
        /// Actual value, in metres or radians.
        actual: f64,
    },
    /// A scene does not name its robot, and none is given.
    #[error("{}: the scene does not name its robot (give its URDF: --robot URDF)", path.display())]
    NoRobotName {
        /// The scene file.
        path: PathBuf,
    },
    /// A joint has two values.
    #[error("{at}: joint '{joint}' has a value already")]
    JointTwice {
        /// Location of the second one.
        at: Location,
        /// Name of the joint.
        joint: String,
    },
    /// A `MoveIt` request has no goal.
    #[error("{}: no goal: 'goal_constraints' must hold joint constraints", path.display())]
    NoGoal {
        /// The request file.
        path: PathBuf,
    },
    /// The goal gives no value for a joint.
    #[error("{at}: the goal gives no value for joint '{joint}'")]
    GoalWithoutJoint {
        /// Location of the goal in the file.
        at: Location,
        /// Name of the joint.
        joint: String,
    },
    /// A `MoveIt` object has no shape.
    #[error("{at}: object '{object}' has neither primitives nor meshes")]
    NoShape {
        /// Location in the file.
        at: Location,
        /// Name of the object.
        object: String,
    },
    /// The number of shapes of a `MoveIt` object differs from the number of their poses.
    #[error("{at}: object '{object}' has {actual} poses for {expected} shapes of kind {kind}")]
    PoseCount {
        /// Location in the file.
        at: Location,
        /// Name of the object.
        object: String,
        /// `primitive` or `mesh`.
        kind: &'static str,
        /// Number of shapes.
        expected: usize,
        /// Number of poses.
        actual: usize,
    },
    /// A `MoveIt` primitive has an unknown kind.
    #[error("{at}: object '{object}': unknown primitive '{kind}' (known: box, sphere, cylinder)")]
    UnknownPrimitive {
        /// Location in the file.
        at: Location,
        /// Name of the object.
        object: String,
        /// Kind of the primitive.
        kind: String,
    },
    /// A `MoveIt` primitive has the wrong number of dimensions.
    #[error("{at}: object '{object}': {actual} dimensions, but those of a {kind} are [{expected}]")]
    Dimensions {
        /// Location in the file.
        at: Location,
        /// Name of the object.
        object: String,
        /// Kind of the primitive.
        kind: String,
        /// Description of its dimensions.
        expected: &'static str,
        /// Actual number of dimensions.
        actual: usize,
    },
    /// A pose refers to a frame that is unknown or not fixed.
    #[error("{at}: unknown frame '{frame}' (known: {known})")]
    UnknownFrame {
        /// Location in the file.
        at: Location,
        /// Name of the frame.
        frame: String,
        /// Names of the known frames.
        known: String,
    },
    /// A `MoveIt` file names a joint or a group that the robot does not have.
    #[error("{at}: {reason}")]
    NotOfRobot {
        /// Location in the file.
        at: Location,
        /// Error of the robot.
        reason: Box<cranny_robot::RobotError>,
    },
    /// No robot is given or found for a `MoveIt` scene.
    #[error("{}: no URDF of the robot is given or found; looked for {}", path.display(), listed(tried))]
    NoRobot {
        /// The scene file.
        path: PathBuf,
        /// Files that were searched.
        tried: Vec<PathBuf>,
    },
}

fn listed(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}
