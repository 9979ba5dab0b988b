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

mod approach_sphere;
mod audit;
mod baseline_check;
mod bidirectional;
mod box_pages;
mod carry;
mod closing_hand;
mod connector;
mod corner_blend;
mod error;
mod even_sequence;
mod forest;
mod goal_meter;
mod goal_pool;
mod grasp_failure;
mod grasp_poses;
mod grasp_reach;
mod grasp_rrt;
mod grasp_source;
mod growth;
mod hand_filter;
mod ik_annotation;
mod ik_pipeline;
mod ik_rbt;
mod ik_rrt;
mod j_plus_rbt;
mod j_plus_rrt;
mod jacobian_search;
mod jerk_limited;
mod joint_metric;
mod lane_search;
mod laps;
mod motion_limits;
mod near_set;
mod nearest;
mod not_checked;
mod optimise;
mod own_grasp;
mod path_cost;
mod path_curve;
mod planner;
mod prm;
mod problem;
mod rbt_connect;
mod reach;
mod registry;
mod roadmap;
mod rrt;
mod rrt_connect;
mod rrt_star;
mod search;
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
pub use grasp_reach::GraspReach;
pub use grasp_rrt::GraspRrt;
pub use hand_filter::{APPROACH_M, HandFilter, robot_hand};
pub use ik_annotation::{
    AnnotatedSolution, IkAnnotation, IkAnnotationSettings, IkMethod, IkStatus, annotate_ik,
};
pub use ik_rbt::IkRbt;
pub use ik_rrt::IkRrt;
pub use j_plus_rbt::JPlusRbt;
pub use j_plus_rrt::JPlusRrt;
pub use jacobian_search::GraspChoice;
pub use motion_limits::{MotionLimits, TimingMethod};
pub use nearest::{EXACT_BELOW, FARTHER_BY, NearestNeighbours};
pub use not_checked::{NotChecked, NotCheckedReason, search};
pub use optimise::{Improvement, OptimiseSettings, Optimised, better, optimise, other_seed};
pub use own_grasp::{GraspMeasure, OwnGrasp};
pub use path_cost::{CostKind, PathCost};
pub use planner::{Budget, Observer, Outcome, PlanReport, Planner, Statistics, Unobserved};
pub use prm::Prm;
pub use problem::{Criterion, Goal, PAPER_THRESHOLD, Problem};
pub use rbt_connect::RbtConnect;
pub use reach::Reach;
pub use registry::{default_planner, grasp_makers, planner, planner_names, planner_with};
pub use roadmap::{Roadmap, RoadmapFile};
pub use rrt::Rrt;
pub use rrt_connect::RrtConnect;
pub use rrt_star::RrtStar;
pub use shortcut::{ShortcutSettings, Shortened, shortcut};
pub use task_audit::{TaskPath, audit_task};
pub use trajectory::{MAX_SAMPLE_RATE_HZ, Trajectory, TrajectorySample, sample_times};
pub use violation::{JointOffset, Place, Violation};
