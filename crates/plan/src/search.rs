//! Building blocks of planners: the trait [`Planner`](crate::Planner), trees and their nearest neighbours, samples, goals.

pub(crate) mod approach_sphere;
pub(crate) mod base_shift;
pub(crate) mod baseline_check;
pub(crate) mod bidirectional;
pub(crate) mod clock;
pub(crate) mod connector;
pub(crate) mod forest;
pub(crate) mod goal_meter;
pub(crate) mod goal_pool;
pub(crate) mod graph;
pub(crate) mod grasp_source;
pub(crate) mod growth;
pub(crate) mod ik_pipeline;
pub(crate) mod jacobian_search;
pub(crate) mod no_grasp;
pub(crate) mod path_search;
pub(crate) mod planner;
pub(crate) mod pose_source;
pub(crate) mod ranges;
pub(crate) mod search_state;
