#![doc = include_str!("../README.md")]

mod arm;
mod contact_patch;
mod course;
mod disturbance;
mod engine;
mod error;
mod experiment;
#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]
mod friction_tests;
mod grasp_rows;
mod grasp_run;
mod grasp_test;
mod grasp_trial;
mod gripper;
mod limit_surface;
mod mjcf;
mod object_model;
mod physics;
mod piece;
mod plan_execution;
mod plan_row;
mod plan_run;
mod plan_test;
mod recording;
mod settling;

pub use crate::arm::DriveSettings;
pub use crate::course::Course;
pub use crate::disturbance::{Disturbance, Uncertainty};
pub use crate::error::SimError;
pub use crate::experiment::{Experiment, ExperimentPose};
pub use crate::grasp_rows::GraspRow;
pub use crate::grasp_run::{GraspOutcome, GraspRun};
pub use crate::grasp_test::GraspTest;
pub use crate::physics::Physics;
pub use crate::piece::{Piece, PieceShape};
pub use crate::plan_execution::{PickPath, PickRun, PlanExecution};
pub use crate::plan_row::{ExecutedPick, ExecutedPlan, PlanRow, Released};
pub use crate::plan_run::{PlacedError, PlanContact, PlanOutcome, PlanRun, TrackingError};
pub use crate::plan_test::PlanTest;
pub use crate::recording::{RecordedBody, Recording};
pub use crate::settling::{ChiSquared, SettledPose, Settling, settle};
