use std::fmt;
use std::path::PathBuf;

use cranny_file::distinct;

/// Difference between a [`MoveItProblem`](crate::MoveItProblem) and its files, or content that it covers only partly.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MoveItDeviation {
    /// A joint outside the group has a value beyond its limits and is fixed at the limit.
    HeldAtLimit {
        /// Name of the joint.
        joint: String,
        /// Value in the files, in metres or radians.
        requested: f64,
        /// Value used instead, in metres or radians.
        held: f64,
    },
    /// A joint that follows another, or is fixed in the URDF, differs from its value in the files.
    NotFree {
        /// Name of the joint.
        joint: String,
        /// Value in the files, in metres or radians.
        requested: f64,
        /// Actual value, in metres or radians.
        held: f64,
    },
    /// Neither file gives a value for a joint outside the group.
    NotGiven {
        /// Name of the joint.
        joint: String,
        /// Actual value, in metres or radians.
        held: f64,
    },
    /// A value exceeds a limit by no more than rounding, and the limit is used instead.
    Rounded {
        /// `start` or `goal`.
        what: &'static str,
        /// Name of the joint.
        joint: String,
        /// Value in the files, in metres or radians.
        requested: f64,
        /// Limit, in metres or radians.
        limit: f64,
    },
    /// A continuous joint is shifted by whole turns, which does not move any link.
    Turned {
        /// `start` or `goal`.
        what: &'static str,
        /// Name of the joint.
        joint: String,
        /// Value in the files, in radians.
        requested: f64,
        /// Value used instead, in radians.
        taken: f64,
    },
    /// The start has a velocity, but a path begins at rest.
    Moves {
        /// Name of a joint.
        joint: String,
        /// Velocity in the files (m/s, rad/s).
        velocity: f64,
    },
    /// A joint that is passive in the SRDF moves because a goal requires it.
    PassiveMoves {
        /// Name of the joint.
        joint: String,
    },
    /// The group moves the robot as a whole, which is stationary here.
    BaseStands {
        /// Name of the virtual joint.
        joint: String,
    },
    /// The robot has the base pose of its state, although its SRDF has no movable virtual joint of that name.
    BasePlaced {
        /// Name in the state.
        joint: String,
    },
    /// The scene allows a contact that the robot's SRDF does not; the pair is checked all the same.
    AllowedPairChecked {
        /// Name of a link.
        first: String,
        /// Name of another link, or of an object.
        second: String,
    },
    /// The scene or the SRDF allows a link or object to touch anything; its pairs with objects are checked all the same.
    AllowedLinkChecked {
        /// Name of the link or object.
        name: String,
    },
    /// The scene is for a robot of another name.
    OtherRobot {
        /// Name in the scene.
        scene: String,
        /// Name in the URDF.
        robot: String,
    },
    /// An orientation constraint is replaced by cones about axes of its link, which lie within its tolerances.
    Cones {
        /// Name of the link.
        link: String,
    },
    /// The scene contains no object.
    EmptyWorld,
    /// Joint limits are taken from a `joint_limits.yaml`.
    JointLimits {
        /// Path of the file.
        path: PathBuf,
    },
}

impl fmt::Display for MoveItDeviation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::HeldAtLimit { joint, requested, held } => {
                write!(formatter, "joint '{joint}' is held at its limit {held} instead of {requested}")
            }
            Self::NotFree { joint, requested, held } => {
                let [held, requested] = distinct([*held, *requested], 4);
                write!(
                    formatter,
                    "joint '{joint}' stands at {held} instead of {requested}: it follows another, or is fixed"
                )
            }
            Self::NotGiven { joint, held } => {
                write!(formatter, "joint '{joint}' stands at {held}: neither file gives it a value")
            }
            Self::Rounded { what, joint, requested, limit } => {
                let [requested, limit] = distinct([*requested, *limit], 4);
                write!(
                    formatter,
                    "joint '{joint}' of the {what} is {requested}, read as its limit {limit}, from which it \
                     differs by rounding only"
                )
            }
            Self::Turned { what, joint, requested, taken } => {
                write!(
                    formatter,
                    "joint '{joint}' of the {what} is {requested:.4}, whole turns from {taken:.4}, which is \
                     used instead"
                )
            }
            Self::Moves { joint, velocity } => {
                write!(
                    formatter,
                    "joint '{joint}' moves at the start ({velocity:.4}), but a path begins at rest"
                )
            }
            Self::PassiveMoves { joint } => write!(
                formatter,
                "joint '{joint}' is passive in the SRDF, and moves as if it were driven, because a goal asks for it"
            ),
            Self::BaseStands { joint } => {
                write!(formatter, "virtual joint '{joint}' of the group stands still here")
            }
            Self::BasePlaced { joint } => write!(
                formatter,
                "the base of the robot is at the pose of '{joint}' in its state, which is not a movable \
                 virtual joint of its SRDF"
            ),
            Self::AllowedPairChecked { first, second } => {
                write!(formatter, "'{first}' may touch '{second}' in the scene, but not here")
            }
            Self::AllowedLinkChecked { name } => {
                write!(formatter, "'{name}' may touch any object by its files, but not here")
            }
            Self::OtherRobot { scene, robot } => {
                write!(formatter, "the scene is that of robot '{scene}', the URDF describes '{robot}'")
            }
            Self::Cones { link } => write!(
                formatter,
                "the orientation of '{link}' is kept in cones about its axes, which lie within the tolerances"
            ),
            Self::EmptyWorld => {
                formatter.write_str("the scene holds no object: nothing but the robot itself is in its way")
            }
            Self::JointLimits { path } => {
                write!(formatter, "joint limits are taken from {}", path.display())
            }
        }
    }
}
