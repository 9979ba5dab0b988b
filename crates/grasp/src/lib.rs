//! Grasps: where a gripper would be, how good that is, how far one grasp is from another, and the files that
//! hold sets of them.
//!
//! The **gripper frame** has its origin between the finger pads, y along the axis on which the fingers close,
//! z out of the palm, the approach direction. A parallel gripper turned by 180° about z is the same grasp.
//!
//! ## Limits
//! Parallel grippers only. Grasps are read and compared here, not sampled or scored.

mod error;
mod file;
mod grasp;
mod homogeneous;

pub use error::GraspError;
pub use file::{read_csv, write_csv};
pub use grasp::{Grasp, GraspSet};
pub use homogeneous::pose_of_rows;
