#![doc = include_str!("../README.md")]

mod answer;
mod error;
mod hold_factors;
mod ik_status;
mod least_length;
mod paces;
mod request;
mod robustness;
mod rounding;
mod solve;
mod stages;
mod task_trajectory;
mod tilt;
mod way_search;

pub use answer::{Answer, Optimisation, Shortening, Timed};
pub use error::SolveError;
pub use hold_factors::HoldFactors;
pub use ik_status::ik_statuses;
pub use least_length::least_length;
pub use paces::{Paces, SET_DOWN_M_S};
pub use request::{DEFAULT_HOLD, MOST_HOLD, Request, Timing};
pub use robustness::{JointRadius, PoseRadius, Robustness};
pub use solve::{solve, solve_with};
pub use task_trajectory::{CLOSING_S, HandMotion, TaskTrajectory};
pub use tilt::{Tilt, ToolSlack};
