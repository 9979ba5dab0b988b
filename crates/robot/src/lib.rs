//! Where the links are: a robot from its URDF, SRDF, `robot.yaml` and `limits.yaml`, the pose of every link, Jacobians
//! and inverse kinematics.
//!
//! [`Robot`] is immutable and shared between threads; what a computation writes to lives in a scratch value
//! of the caller ([`LinkFrames`], [`Jacobian`], [`IkSolver`], [`IkBatch`], [`IkSearch`]).
//!
//! ```
//! use cranny_robot::{Robot, RobotOptions};
//!
//! let urdf = r#"<robot name="slide">
//!   <link name="rail"/><link name="cart"/>
//!   <joint name="drive" type="prismatic">
//!     <parent link="rail"/><child link="cart"/><axis xyz="1 0 0"/>
//!     <limit lower="-1" upper="1" velocity="0.5" effort="1"/>
//!   </joint>
//! </robot>"#;
//! let robot = Robot::from_urdf_text(urdf, "slide.urdf", None, &RobotOptions::default())?;
//! assert_eq!(robot.frames_at(&[0.25]).link(robot.tip()).translation.x, 0.25);
//! # Ok::<(), cranny_robot::RobotError>(())
//! ```
//!
//! All poses are `root_from_link`: the robot's root link is the planning frame. The order of `q` is the
//! order of the joint group, [`Robot::joint_names`].
//!
//! ## Limits
//! At most [`MAX_LINKS`] links and joints. Open trees only: no closed chains; ball joints are refused. Continuous joints
//! are revolute joints with limits of ±3π ([`CONTINUOUS_LIMIT_RAD`]), planar and floating joints chains of three and six
//! joints (`NAME/x`, `NAME/y`, …) that go ±2 m ([`FREE_JOINT_LIMIT_M`]), unless `limits.yaml` says otherwise. Textures, transmissions,
//! safety controllers and sensors of a URDF are not read; of an SRDF, virtual joints and sphere approximations are not. A mesh stands for its convex hull unless [`MeshUse::Solid`] is asked for.
//! Inverse kinematics is numerical: it may miss a solution that exists, and proves nothing by finding none.

mod assembly;
mod derived;
mod error;
mod frame_error;
mod free_joint;
mod full_turn;
mod hand;
mod holding;
mod ik_batch;
mod ik_lanes;
mod ik_search;
mod inertial;
mod inverse_kinematics;
mod jacobian;
mod joint_group;
mod joint_reach;
mod joint_space;
mod kinematics;
mod lane_chain;
mod lane_kinematics;
mod limits;
mod link_pairs;
mod mesh_path;
mod model;
mod moving_base;
mod options;
mod reach_bound;
mod robot_description;
mod robot_files;
mod spelling;
mod srdf;
mod steadiness;
mod tree;
mod urdf;
mod urdf_text;
mod visual;
mod xml;

pub use assembly::UrdfFile;
pub use error::{Hindrance, Location, RobotError};
pub use hand::{FingerRange, HandDescription, HandJoint, RobotHand};
pub use holding::{FARTHEST_HELD_M, Hold};
pub use ik_batch::{IK_BATCH, IkBatch};
pub use ik_search::{IkSearch, IkSearchSettings, solve_restarts};
pub use inertial::Inertial;
pub use inverse_kinematics::{IkSettings, IkSolution, IkSolver};
pub use jacobian::{DampedInverse, Jacobian, Twist, damped_pseudo_inverse_step};
pub use joint_space::{between, distance};
pub use kinematics::LinkFrames;
pub use lane_kinematics::{LaneFrame, LaneKinematics, LanePlace, LanePlacement, LaneTwist};
pub use limits::{
    CONTINUOUS_LIMIT_RAD, FREE_JOINT_LIMIT_M, JointLimits, JointUnit, LimitViolation, LimitsFile,
};
pub use model::{GroupJoint, JointKind, Link, LinkShape, Mover, Robot};
pub use options::{JointGroup, MeshUse, RobotOptions, TextSource};
pub use reach_bound::ReachBound;
pub use robot_description::RobotDescription;
pub use robot_files::RobotFiles;
pub use srdf::{EndEffector, GroupState, Srdf, SrdfGroup};
pub use tree::MAX_LINKS;
pub use urdf_text::{JointFacts, JointMotion, MountingJoint, UrdfText};
pub use visual::{LinkForm, LinkVisual};
