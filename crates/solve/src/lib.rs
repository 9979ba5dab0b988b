#![doc = include_str!("../README.md")]

mod answer;
mod error;
mod ik_status;
mod put_down;
mod request;
mod robustness;
mod segment;
mod solve;
mod task;
mod task_cells;
mod task_trajectory;
mod ways_out;

pub use answer::{Answer, Optimisation, Shortening, Timed};
pub use error::SolveError;
pub use ik_status::ik_statuses;
pub use request::{FARTHEST_CLEAR_M, Request, Timing};
pub use robustness::{JointRadius, PoseRadius, Robustness};
pub use segment::Mode;
pub use segment::Segment;
pub use segment::joined;
pub use solve::{audit_segments, solve};
pub use task::Carry;
pub use task_cells::TaskCells;
pub use task_trajectory::{CLOSING_S, HandMotion, TaskTrajectory};
