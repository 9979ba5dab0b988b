#![doc = include_str!("../README.md")]

mod bounding_ball;
mod compliant_pads;
mod contact_patch;
mod engine;
mod error;
#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]
mod friction_tests;
mod grasping;
mod gripper;
mod object_model;
#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]
mod pad_tests;
mod physics;
mod piece;
mod plans;
mod recording;
mod rest;
mod rolling;
mod settling;
mod shell;
mod spring_tip;

pub use crate::error::SimError;
pub use crate::grasping::disturbance::{Disturbance, Uncertainty};
pub use crate::grasping::experiment::{Experiment, ExperimentPose, UnseenTurns};
pub use crate::grasping::grasp_rows::GraspRow;
pub use crate::grasping::grasp_run::{GraspOutcome, GraspRun};
pub use crate::grasping::grasp_test::GraspTest;
pub use crate::physics::Physics;
pub use crate::piece::{Piece, PieceShape};
pub use crate::plans::plan_execution::{PickPath, PickRun, PlanExecution};
pub use crate::plans::plan_experiment::PlanExperiment;
pub use crate::plans::plan_row::{ExecutedPick, ExecutedPlan, PlanRow, Released, StopReason};
pub use crate::plans::plan_run::{ContactPhase, PlacedError, PlanContact, PlanOutcome, PlanRun};
pub use crate::plans::plan_test::PlanTest;
pub use crate::plans::replanning::Replanned;
pub use crate::plans::simulated_answer::{SimulatedAnswer, solve_in_physics};
pub use crate::recording::{RecordedBody, Recording};
pub use crate::rest::Rest;
pub use crate::settling::{ChiSquared, SettledPose, Settling, settle};
