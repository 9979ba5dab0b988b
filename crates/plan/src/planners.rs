//! Planners, one per file, and the registry that lists them by name.

pub(crate) mod approach_rrt;
pub(crate) mod baselines;
pub(crate) mod even_sequence;
pub(crate) mod grasp_reach;
pub(crate) mod grasp_rrt;
pub(crate) mod ik_rbt;
pub(crate) mod ik_rrt;
pub(crate) mod j_plus_rbt;
pub(crate) mod j_plus_rrt;
pub(crate) mod lane_search;
pub(crate) mod laps;
pub(crate) mod optimisers;
pub(crate) mod prm;
pub(crate) mod rbt_connect;
pub(crate) mod reach;
pub(crate) mod reach_settings;
pub(crate) mod registry;
pub(crate) mod rrt;
pub(crate) mod rrt_connect;
pub(crate) mod rrt_star;
