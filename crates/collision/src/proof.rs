//! Proofs that a whole motion is free, and bounds on its clearance.

pub(crate) mod bubble;
pub(crate) mod curve;
pub(crate) mod joint_curve;
pub(crate) mod joint_table;
pub(crate) mod levers;
pub(crate) mod link_sweep;
pub(crate) mod measured_motion;
pub(crate) mod motion;
pub(crate) mod path_clearance;
#[cfg(test)]
mod proof_tests;
pub(crate) mod reach;
pub(crate) mod tool;
pub(crate) mod travel;
pub(crate) mod work_list;
