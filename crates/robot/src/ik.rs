//! Inverse kinematics.

pub(crate) mod ik_batch;
pub(crate) mod ik_lanes;
pub(crate) mod ik_search;
pub(crate) mod inverse_kinematics;
