//! From a problem to an answer, one way for everybody: search, shorten or better, prove, time.
//!
//! A [`Request`] says how a [`Problem`](cranny_plan::Problem) is to be solved; [`solve`] gives an [`Answer`], which the
//! command line, Python, the plan file and the pictures carry and add nothing to. Whoever made a path,
//! [`audit`](cranny_plan::audit) judges it; an answer holds what it said of this one.
//!
//! ## Limits
//! An answer has one segment, which reaches the goal, or three, which take the object away too.

mod answer;
mod error;
mod ik_status;
mod request;
mod solve;
mod task;
mod task_trajectory;
mod ways_out;

pub use answer::{Answer, Mode, Optimisation, Segment, Shortening, Timed, joined};
pub use error::SolveError;
pub use ik_status::ik_statuses;
pub use request::{Request, Timing};
pub use solve::{audit_segments, solve};
pub use task::Carry;
pub use task_trajectory::{CLOSING_S, TaskTrajectory};
