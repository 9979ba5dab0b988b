//! Grasps and contact: sampling, sets, tests in physics.

pub mod contact;
pub mod grasp_sampling;
pub mod grasp_set;
pub mod simulation;
