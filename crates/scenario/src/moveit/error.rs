use std::path::PathBuf;

use cranny_file::distinct;
use cranny_robot::Location;

/// What can be wrong with a `MoveIt` scene, a request, or the robot that they name. The message is complete in itself: file and line where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MoveItError {
    /// A `MoveIt` joint state does not give each joint one position.
    #[error("{at}: the joint state has {names} names, but {values} {kind}")]
    JointState {
        /// Location in the file.
        at: Location,
        /// Number of joints that are named.
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
    /// A file does not hold one message.
    #[error("{}: a list of {actual} messages, but one is read (give that alone)", path.display())]
    NotOneMessage {
        /// The file.
        path: PathBuf,
        /// Number of messages in it.
        actual: usize,
    },
    /// A `.scene` file is not in the form of one.
    #[error("{at}: expected {expected}, not '{found}'")]
    SceneText {
        /// Location in the file.
        at: Location,
        /// The expected content.
        expected: &'static str,
        /// The content that was found.
        found: String,
    },
    /// An `allowed_collision_matrix` is none.
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
    /// A fixed transform puts a frame elsewhere than it is known to be.
    #[error("{at}: frame '{frame}' is known, and elsewhere (leave the transform out)")]
    FrameTwice {
        /// Location in the file.
        at: Location,
        /// The frame.
        frame: String,
    },
    /// The pose of the robot's base is given for something else.
    #[error("{at}: '{joint}' is no virtual joint of the robot's SRDF (it has: {known})")]
    NoVirtualJoint {
        /// Location in the file.
        at: Location,
        /// The name.
        joint: String,
        /// The virtual joints that there are.
        known: String,
    },
    /// A goal asks a joint that follows others, or is held, to be elsewhere.
    #[error(
        "{at}: the goal asks joint '{joint}' to be at {}, but it does not move freely, and is at {} there",
        distinct([*asked, *actual], 4)[0],
        distinct([*asked, *actual], 4)[1]
    )]
    GoalElsewhere {
        /// Location in the file.
        at: Location,
        /// The joint.
        joint: String,
        /// The value in the goal, in metres or radians.
        asked: f64,
        /// The value that it has, in metres or radians.
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
        /// Where the second one stands.
        at: Location,
        /// The joint.
        joint: String,
    },
    /// A `MoveIt` request has no goal.
    #[error("{}: no goal: 'goal_constraints' must hold joint constraints", path.display())]
    NoGoal {
        /// The request file.
        path: PathBuf,
    },
    /// The goal leaves a joint out.
    #[error("{at}: the goal gives no value for joint '{joint}'")]
    GoalWithoutJoint {
        /// Where the goal stands.
        at: Location,
        /// The joint.
        joint: String,
    },
    /// A `MoveIt` object has no shape.
    #[error("{at}: object '{object}' has neither primitives nor meshes")]
    NoShape {
        /// Location in the file.
        at: Location,
        /// The object.
        object: String,
    },
    /// The shapes of a `MoveIt` object do not have one pose each.
    #[error("{at}: object '{object}' has {actual} poses for {expected} shapes of kind {kind}")]
    PoseCount {
        /// Location in the file.
        at: Location,
        /// The object.
        object: String,
        /// `primitive` or `mesh`.
        kind: &'static str,
        /// How many shapes there are.
        expected: usize,
        /// How many poses.
        actual: usize,
    },
    /// A `MoveIt` primitive is of a kind that is not known.
    #[error("{at}: object '{object}': unknown primitive '{kind}' (known: box, sphere, cylinder)")]
    UnknownPrimitive {
        /// Location in the file.
        at: Location,
        /// The object.
        object: String,
        /// The kind.
        kind: String,
    },
    /// A `MoveIt` primitive has the wrong number of dimensions.
    #[error("{at}: object '{object}': {actual} dimensions, but those of a {kind} are [{expected}]")]
    Dimensions {
        /// Location in the file.
        at: Location,
        /// The object.
        object: String,
        /// The kind of primitive.
        kind: String,
        /// What its dimensions are.
        expected: &'static str,
        /// How many there are.
        actual: usize,
    },
    /// A pose is given in a frame that is not known to stand still.
    #[error("{at}: unknown frame '{frame}' (known: {known})")]
    UnknownFrame {
        /// Location in the file.
        at: Location,
        /// The frame.
        frame: String,
        /// The frames that there are.
        known: String,
    },
    /// A `MoveIt` file names a joint or a group that the robot does not have.
    #[error("{at}: {reason}")]
    NotOfRobot {
        /// Location in the file.
        at: Location,
        /// What the robot says.
        reason: Box<cranny_robot::RobotError>,
    },
    /// A `MoveIt` scene comes without a robot.
    #[error("{}: no URDF of the robot is given or found; looked for {}", path.display(), listed(tried))]
    NoRobot {
        /// The scene file.
        path: PathBuf,
        /// The files that were looked for.
        tried: Vec<PathBuf>,
    },
}

fn listed(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}
