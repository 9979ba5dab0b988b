//! Timing of paths: limits, time laws, trajectories.

pub(crate) mod drives;
pub(crate) mod motion_limits;
pub(crate) mod path_curve;
pub(crate) mod piece_limits;
pub(crate) mod refinement;
pub(crate) mod rounding;
pub(crate) mod s_curve;
pub(crate) mod time_law;
pub(crate) mod time_optimal;
#[cfg(test)]
mod time_optimal_tests;
pub(crate) mod trajectory;
