#![doc = include_str!("../README.md")]

mod chain;
mod description;
mod error;
mod free_joint;
mod gripper;
mod ik;
mod joint_constraint;
mod link;
mod link_pairs;
mod location;
mod mjcf;
mod model;
mod model_file;
mod sdf;
mod tree;

pub use chain::dynamics::{Dynamics, PathForces};
pub use chain::jacobian::{DampedInverse, Jacobian, Twist, damped_pseudo_inverse_step};
pub use chain::joint_space::{between, distance};
pub use chain::kinematics::{LinkFrames, LinkPath};
pub use chain::lane_kinematics::{LaneFrame, LaneKinematics, LanePlacement, LaneTransform, LaneTwist};
pub use chain::limits::{
    CONTINUOUS_LIMIT_RAD, DEFAULT_SPEED_M_S, DEFAULT_SPEED_RAD_S, FREE_JOINT_LIMIT_M, JointLimits, JointUnit,
    LimitViolation,
};
pub use chain::link_motion::{LinkJoint, LinkMotion};
pub use chain::reach_bound::ReachBound;
pub use description::assembly::UrdfFile;
pub use description::inertial::Inertial;
pub use description::mesh_path::candidates as mesh_candidates;
pub use description::options::{JointGroup, MeshUse, RateScales, RobotOptions};
pub use description::rate_limits::LimitsFile;
pub use description::robot_description::RobotDescription;
pub use description::robot_files::RobotFiles;
pub use description::srdf::{EndEffector, GroupState, Srdf, SrdfGroup, VirtualJoint, VirtualJointKind};
pub use description::text_source::TextSource;
pub use description::urdf_text::{JointFacts, JointMotion, MountingJoint, UrdfText};
pub use description::visual::{LinkForm, LinkVisual};
pub use error::RobotError;
pub use gripper::hand::RobotHand;
pub use gripper::hand_description::FingerRange;
pub use gripper::hand_description::{HandDescription, PadDescription};
pub use gripper::hand_joint::HandJoint;
pub use gripper::holding::FARTHEST_HELD_M;
pub use gripper::loose_links::Hold;
pub use gripper::pad_distance::PadDistance;
pub use gripper::tool_description::ToolDescription;
pub use ik::ik_batch::{IK_BATCH, IkBatch};
pub use ik::ik_search::{IkSearch, IkSearchSettings, solve_restarts};
pub use ik::inverse_kinematics::{IkSettings, IkSolution, IkSolver};
pub use joint_constraint::JointConstraint;
pub use link::GroupJoint;
pub use link::JointKind;
pub use link::Link;
pub use link::LinkShape;
pub use link::Mover;
pub use location::Location;
pub use model::Robot;
pub use model_file::body_tree::Plane;
pub use model_file::model_text::ModelText;
pub use model_file::urdf_writer::ModelUse;
pub use model_file::world_links::WorldLink;
pub use tree::MAX_LINKS;
