use std::path::PathBuf;

use cranny_collision::CollisionError;
use cranny_robot::RobotError;
use cranny_scenario::ScenarioError;

/// Reason why a robot cannot be set up from a URDF.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SetupError {
    /// A robot file has a fault.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// A folder cannot be written.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A link cannot be checked.
    #[error(transparent)]
    Collision(#[from] CollisionError),
    /// A xacro file is not expanded.
    #[error("{} is a xacro file, which becomes a URDF by `xacro {} > robot.urdf`: {reason}", path.display(), path.display())]
    Xacro {
        /// The file.
        path: PathBuf,
        /// Reason why it is not expanded here.
        reason: String,
    },
    /// The robot has neither an arm nor a hand.
    #[error(
        "{file}: nothing here can grasp: no joint moves {} ({joints}). Give the URDF of the whole robot{}",
        tip.as_ref().map_or_else(|| "a hand or a tool".to_owned(), |tip| format!("--tip {tip}")),
        if tip.is_none() { ", or the link that grasps by --tip LINK" } else { ", or another link" }
    )]
    NoArm {
        /// The file.
        file: String,
        /// Requested tip link, if given.
        tip: Option<String>,
        /// Joints that move.
        joints: String,
    },
    /// Most joints have no range.
    #[error(
        "{file}: {joints}: lower and upper limit are the same, so nothing moves (a <limit> without lower and upper means 0 \
         to 0: give both, or make the joint continuous)"
    )]
    NoRange {
        /// The file.
        file: String,
        /// The joints.
        joints: String,
    },
    /// A named link does not exist, or carries no hand.
    #[error("{file}: {what}")]
    NotThere {
        /// The file.
        file: String,
        /// Description of the fault.
        what: String,
    },
    /// No drawn configuration is free of self-collision.
    #[error(
        "{file}: in each of the drawn configurations the robot touches itself or the ground, mostly {pair}: \
         if links may touch there, declare them in an SRDF (<disable_collisions link1=… link2=… reason=…/>) \
         and give it with --srdf"
    )]
    NeverFree {
        /// The file.
        file: String,
        /// Links that touch most often.
        pair: String,
    },
}
