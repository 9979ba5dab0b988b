//! How do I get there? Problems, planners, paths, and the judgement of paths from anywhere.
//!
//! A [`Problem`] goes to a [`Planner`] with a [`Budget`] and a seed, and comes back as a [`PlanReport`]. The
//! planners are pure functions of these, found by name through [`planner`]. Under the `exact` criterion a
//! tree grows only along proven edges, so no path leaves a planner unproven; [`audit`] judges any path,
//! whoever made it. A [`Trajectory`] gives a path its time.
//!
//! ## Limits
//! Paths are way points joined by straight lines in configuration space, and trajectories stop where two
//! lines meet at an angle, unless the corner may be cut. They keep to limits of joints, not of torques or of the speed of a link. Obstacles
//! stand still.

mod audit;
mod baseline_check;
mod box_pages;
mod carry;
mod corner_blend;
mod error;
mod forest;
mod goal_meter;
mod goal_pool;
mod grasp_failure;
mod grasp_poses;
mod hand_filter;
mod ik_annotation;
mod ik_rrt;
mod j_plus_rrt;
mod jerk_limited;
mod joint_metric;
mod motion_limits;
mod nearest;
mod not_checked;
mod optimise;
mod path_cost;
mod path_curve;
mod planner;
mod problem;
mod reach;
mod registry;
mod search_tree;
mod shortcut;
mod step;
mod task_audit;
mod time_law;
mod time_optimal;
#[cfg(test)]
mod time_optimal_tests;
mod trajectory;
mod violation;

pub use audit::{Audit, AuditSettings, Clearances, GoalError, audit, audit_with, path_length};
pub use carry::{Carrier, CarryEnd, Grip, LiftOffSettings};
pub use error::PlanError;
pub use grasp_failure::{FailureReason, GraspFailure};
pub use hand_filter::{APPROACH_M, HandFilter, robot_hand};
pub use ik_annotation::{
    AnnotatedSolution, IkAnnotation, IkAnnotationSettings, IkMethod, IkStatus, annotate_ik,
};
pub use ik_rrt::IkRrt;
pub use j_plus_rrt::{GraspChoice, JPlusRrt};
pub use motion_limits::{MotionLimits, TimingMethod};
pub use nearest::{EXACT_BELOW, FARTHER_BY, NearestNeighbours};
pub use not_checked::{NotChecked, NotCheckedReason, search};
pub use optimise::{Improvement, OptimiseSettings, Optimised, optimise, other_seed};
pub use path_cost::PathCost;
pub use planner::{Budget, Observer, Outcome, PlanReport, Planner, Statistics, Unobserved};
pub use problem::{Criterion, Goal, PAPER_THRESHOLD, Problem};
pub use reach::Reach;
pub use registry::{default_planner, planner, planner_names, planner_with};
pub use shortcut::{ShortcutSettings, Shortened, shortcut};
pub use task_audit::{TaskPath, audit_task};
pub use trajectory::{MAX_SAMPLE_RATE_HZ, Trajectory, TrajectorySample, sample_times};
pub use violation::{JointOffset, Place, Violation};
