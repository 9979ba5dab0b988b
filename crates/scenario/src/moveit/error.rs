use std::path::PathBuf;

use cranny_robot::Location;

/// What can be wrong with a `MoveIt` scene, a request, or the robot that they name. The message is complete in itself: file and line where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MoveItError {
    /// A `MoveIt` joint state does not give each joint one position.
    #[error("{at}: the joint state has {names} names, but {values} positions")]
    JointState {
        /// Where.
        at: Location,
        /// How many joints are named.
        names: usize,
        /// How many positions there are.
        values: usize,
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
        /// Where.
        at: Location,
        /// The object.
        object: String,
    },
    /// The shapes of a `MoveIt` object do not have one pose each.
    #[error("{at}: object '{object}' has {actual} poses for {expected} shapes of kind {kind}")]
    PoseCount {
        /// Where.
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
        /// Where.
        at: Location,
        /// The object.
        object: String,
        /// The kind.
        kind: String,
    },
    /// A `MoveIt` primitive has the wrong number of dimensions.
    #[error("{at}: object '{object}': {actual} dimensions, but those of a {kind} are [{expected}]")]
    Dimensions {
        /// Where.
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
        /// Where.
        at: Location,
        /// The frame.
        frame: String,
        /// The frames that there are.
        known: String,
    },
    /// A `MoveIt` file names a joint or a group that the robot does not have.
    #[error("{at}: {reason}")]
    NotOfRobot {
        /// Where.
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
