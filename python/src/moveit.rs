//! Problems and requests of MoveIt.

pub mod planner;
mod problem;
pub mod scene;
