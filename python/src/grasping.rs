//! Grasps and contact: sampled, kept in a set, tried in physics.

pub mod contact;
pub mod grasp_sampling;
pub mod grasp_set;
pub mod simulation;
