#![doc = include_str!("../README.md")]

mod configuration_fault;
mod error;
mod goal;
mod grasping;
mod ik_annotation;
mod not_checked;
mod placing;
mod problem;
mod stages;

pub use configuration_fault::{ConfigurationFault, ends_out_of_bounds};
pub use error::TaskError;
pub use goal::Goal;
pub use grasping::closing_hand::{ClosedHand, ClosingHand};
pub use grasping::found_grasp::FoundGrasp;
pub use grasping::grasp_failure::{FailureReason, GraspFailure, hand_collides};
pub use grasping::grasp_filter::GraspFilter;
pub use grasping::grasp_measure::GraspMeasure;
pub use grasping::grasp_poses::{gripper_poses, open_gripper_poses};
pub use grasping::grasp_regions::grasp_regions;
pub use grasping::hand_filter::{APPROACH_M, HandFilter, robot_hand};
pub use grasping::load_model::{LoadModel, Weight};
pub use ik_annotation::{
    AnnotatedSolution, IkAnnotation, IkAnnotationSettings, IkMethod, IkStatus, annotate_ik,
};
pub use not_checked::{AllowedContact, ContactSegment, NotChecked, NotCheckedReason};
pub use placing::carry::{Carrier, Grip, LiftOffSettings};
pub use placing::place::Placer;
pub use placing::place_goal::{PlaceGoal, PlaceRegion};
pub use placing::placed::Placed;
pub use placing::placement::Placement;
pub use problem::Validity;
pub use problem::{Criterion, PAPER_THRESHOLD, Problem};
pub use stages::corner::RoundedCorner;
pub use stages::payload::Payload;
pub use stages::pose_bounds::PoseBounds;
pub use stages::region::{Moved, Region, RegionFrame};
pub use stages::segment::{Mode, MotionEnd, Segment, give_clearances, joined, joined_corners, legs};
pub use stages::speed_limits::SpeedLimits;
pub use stages::stage::{AfterPlacing, CLEAR_M, FARTHEST_CLEAR_M, Move, Pick, PlaceAt, Stage};
pub use stages::stage_segments::{are_complete, are_joined, check_segments, number_stages, picks_apart};
pub use stages::state::{State, StateSequence};
pub use stages::straight::{StraightLine, straight_line};
