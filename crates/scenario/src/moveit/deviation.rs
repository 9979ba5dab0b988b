use std::fmt;
use std::path::PathBuf;

use cranny_file::distinct;

/// Point at which a [`MoveItProblem`](crate::MoveItProblem) differs from its files, or covers them only in part.
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
    /// A joint that follows another, or is fixed in the URDF, does not stand where the files have it.
    NotFree {
        /// The joint.
        joint: String,
        /// The value in the files, in metres or radians.
        requested: f64,
        /// Its value, in metres or radians.
        held: f64,
    },
    /// Neither file gives a joint outside the group a value.
    NotGiven {
        /// The joint.
        joint: String,
        /// Its value, in metres or radians.
        held: f64,
    },
    /// A value is beyond a limit by no more than rounding, and the limit is taken instead.
    Rounded {
        /// `start` or `goal`.
        what: &'static str,
        /// The joint.
        joint: String,
        /// The value in the files, in metres or radians.
        requested: f64,
        /// The limit.
        limit: f64,
    },
    /// A continuous joint is turned by whole turns, which leaves all links where they are.
    Turned {
        /// `start` or `goal`.
        what: &'static str,
        /// The joint.
        joint: String,
        /// The value in the files, in radians.
        requested: f64,
        /// The value taken instead.
        taken: f64,
    },
    /// The start moves, but a path begins at rest.
    Moves {
        /// A joint.
        joint: String,
        /// Its speed in the files (m/s, rad/s).
        velocity: f64,
    },
    /// A joint that no motor drives, by the SRDF, is moved, because a goal asks for that.
    PassiveMoves {
        /// The joint.
        joint: String,
    },
    /// The group moves the robot as a whole, which stands still here.
    BaseStands {
        /// The virtual joint.
        joint: String,
    },
    /// The robot stands where its state has it, although its SRDF has no virtual joint of that name that moves.
    BasePlaced {
        /// The name in the state.
        joint: String,
    },
    /// The scene lets two things touch that the robot's SRDF does not name; they are checked all the same.
    AllowedPairChecked {
        /// A link.
        first: String,
        /// Another link, or an object.
        second: String,
    },
    /// The scene or the SRDF lets a link or object touch anything; its pairs with objects are checked all the same.
    AllowedLinkChecked {
        /// The link or object.
        name: String,
    },
    /// The scene is that of a robot of another name.
    OtherRobot {
        /// The name in the scene.
        scene: String,
        /// The name in the URDF.
        robot: String,
    },
    /// An orientation constraint is kept as cones about axes of its link, which lie within its tolerances.
    Cones {
        /// The link.
        link: String,
    },
    /// The scene holds no object.
    EmptyWorld,
    /// Limits of joints are those of a `joint_limits.yaml`.
    JointLimits {
        /// The file.
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
                    "joint '{joint}' of the {what} is {requested}, taken for its limit {limit}, of which it is a \
                     rounding"
                )
            }
            Self::Turned { what, joint, requested, taken } => {
                write!(
                    formatter,
                    "joint '{joint}' of the {what} is {requested:.4}, whole turns from {taken:.4}, which is taken"
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
                "the robot stands where its state has '{joint}', which is no virtual joint of its SRDF that moves"
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
                write!(formatter, "limits of joints are those of {}", path.display())
            }
        }
    }
}
