#![doc = include_str!("../README.md")]

mod error;
mod neighbours;
mod optimise;
mod path;
mod planners;
mod search;
mod stages;
mod task;
mod timing;
mod wall_clock;

pub use error::PlanError;
pub use neighbours::nearest::{EXACT_BELOW, FARTHER_BY, NearestNeighbours};
pub use optimise::{Improvement, OptimiseSettings, Optimised, better, optimise};
pub use path::audit::{Audit, AuditSettings, Clearances, audit, audit_with, path_length};
pub use path::clearance_limit::{AppliedMargin, ClearanceLimit};
pub use path::corner_audit::audit_cut_corners;
pub use path::joint_metric::JointMetric;
pub use path::path_cost::{CostKind, PathCost};
pub use path::pick_audit::PickAudit;
pub use path::shortcut::{ShortcutSettings, Shortened, shortcut};
pub use path::task_audit::{audit_along, audit_task};
pub use path::violation::{Cause, GoalError, JointOffset, Location, Violation};
pub use planners::grasp_reach::GraspReach;
pub use planners::grasp_rrt::GraspRrt;
pub use planners::ik_rbt::IkRbt;
pub use planners::ik_rrt::IkRrt;
pub use planners::j_plus_rbt::JPlusRbt;
pub use planners::j_plus_rrt::JPlusRrt;
pub use planners::prm::Prm;
pub use planners::rbt_connect::RbtConnect;
pub use planners::reach_settings::Reach;
pub use planners::registry::{Registry, default_planner};
pub use planners::rrt::Rrt;
pub use planners::rrt_connect::RrtConnect;
pub use planners::rrt_star::RrtStar;
pub use search::clock::Clock;
pub use search::connector::{Connector, Path, connect};
pub use search::forest::Forest;
pub use search::goal_pool::GoalPool;
pub use search::jacobian_search::GraspChoice;
pub use search::no_grasp::{NoGrasp, ReachMiss};
pub use search::path_search::{begin_search, search};
pub use search::planner::{
    Budget, Observer, Outcome, PathSearch, PlanReport, Planner, Statistics, Unobserved,
};
pub use search::ranges::Ranges;
pub use search::roadmap::{Roadmap, RoadmapFile};
pub use search::search_state::Search;
pub use stages::region::{Moved, Region};
pub use stages::segment::{Mode, MotionEnd, Segment, give_clearances, joined, legs};
pub use stages::stage::{AfterPlacing, CLEAR_M, FARTHEST_CLEAR_M, Move, Pick, PlaceAt, Stage};
pub use stages::stage_segments::{are_complete, check_segments, number_stages, picks_apart};
pub use stages::state::{State, StatesAlong};
pub use task::carry::{Carrier, Grip, LiftOffSettings};
pub use task::configuration_fault::ConfigurationFault;
pub use task::grasp_failure::{FailureReason, GraspFailure};
pub use task::grasp_filter::GraspFilter;
pub use task::grasp_measure::GraspMeasure;
pub use task::hand_filter::{APPROACH_M, HandFilter, robot_hand};
pub use task::ik_annotation::{
    AnnotatedSolution, IkAnnotation, IkAnnotationSettings, IkMethod, IkStatus, annotate_ik,
};
pub use task::not_checked::{AllowedContact, ContactSegment, NotChecked, NotCheckedReason};
pub use task::own_grasp::OwnGrasp;
pub use task::place::Placer;
pub use task::place_goal::{PlaceGoal, PlaceSpot};
pub use task::placed::Placed;
pub use task::placement::Placement;
pub use task::problem::{Criterion, Goal, PAPER_THRESHOLD, Problem};
pub use timing::corner_blend::CutCorner;
pub use timing::motion_limits::{MotionLimits, TimingMethod};
pub use timing::trajectory::{MAX_SAMPLE_RATE_HZ, Trajectory, TrajectorySample, sample_times};
