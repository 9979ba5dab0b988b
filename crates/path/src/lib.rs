#![doc = include_str!("../README.md")]

mod audit;
mod clearance_limit;
mod corner_audit;
mod error;
mod grasp_judge;
mod joint_metric;
mod lower_bound;
mod path_cost;
mod pick_audit;
mod pose_clusters;
mod pose_functional;
mod shortcut;
mod step;
mod task_audit;
mod timing;
mod violation;
mod wall_clock;

pub use audit::{Audit, AuditSettings, Clearances, arrival_at, audit, audit_with, path_length};
pub use clearance_limit::{AppliedMargin, ClearanceLimit};
pub use error::PathError;
pub use grasp_judge::GraspJudge;
pub use joint_metric::JointMetric;
pub use lower_bound::least_length;
pub use path_cost::{CostKind, PathCost};
pub use pick_audit::PickAudit;
pub use shortcut::{STOP, ShortcutSettings, Shortened, Shortener, shortcut};
pub use step::{RELEASED_STEP_M, Stepper};
pub use task_audit::{audit_along, audit_task};
pub use timing::drives::Drives;
pub use timing::motion_limits::{MotionLimits, TimingMethod};
pub use timing::piece_limits::EdgePace;
pub use timing::refinement::RefinedPath;
pub use timing::rounding::{CurveProof, CurvedPath};
pub use timing::trajectory::{MAX_SAMPLE_RATE_HZ, Trajectory, TrajectorySample, sample_times};
pub use violation::{Cause, GoalError, JointOffset, Location, Violation};
