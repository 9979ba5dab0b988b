#![doc = include_str!("../README.md")]

mod curves;
mod error;
mod neighbours;
mod optimise;
mod planners;
mod search;
mod wall_clock;

pub use curves::curve_settings::{CurveSettings, FirstCurve};
pub use curves::obstacle_cost::CostRange;
pub use curves::refused_claim::RefusedClaim;
pub use error::PlanError;
pub use neighbours::nearest::{EXACT_BELOW, FARTHER_BY, NearestNeighbours};
pub use optimise::{Improvement, OptimiseSettings, Optimised, better, optimise};
pub use planners::approach_rrt::ApproachRrt;
pub use planners::baselines::cbirrt2::Cbirrt2;
pub use planners::baselines::est::Est;
pub use planners::baselines::kpiece::Kpiece;
pub use planners::baselines::lazy_prm::LazyPrm;
pub use planners::grasp_reach::GraspReach;
pub use planners::grasp_rrt::GraspRrt;
pub use planners::ik_rbt::IkRbt;
pub use planners::ik_rrt::IkRrt;
pub use planners::j_plus_rbt::JPlusRbt;
pub use planners::j_plus_rrt::JPlusRrt;
pub use planners::optimisers::chomp::Chomp;
pub use planners::optimisers::covariant_descent::Descent;
pub use planners::optimisers::goal_learner::GoalChoice;
pub use planners::optimisers::gomp::{Gomp, LimitUse};
pub use planners::optimisers::omg::Omg;
pub use planners::optimisers::stomp::Stomp;
pub use planners::prm::Prm;
pub use planners::rbt_connect::RbtConnect;
pub use planners::reach_settings::Reach;
pub use planners::registry::{Registry, default_planner, is_reached};
pub use planners::rrt::Rrt;
pub use planners::rrt_connect::RrtConnect;
pub use planners::rrt_star::RrtStar;
pub use search::clock::Clock;
pub use search::connector::{Connector, Path, connect};
pub use search::forest::Forest;
pub use search::goal_pool::GoalPool;
pub use search::graph::roadmap::{Roadmap, RoadmapFile};
pub use search::jacobian_search::GraspChoice;
pub use search::no_grasp::{NoGrasp, ReachMiss};
pub use search::path_search::{begin_search, search};
pub use search::planner::{
    Budget, Observer, Outcome, PathSearch, PlanReport, Planner, Statistics, Unobserved,
};
pub use search::ranges::Ranges;
pub use search::search_state::Search;
