//! Limits of every path: lower bounds of the length, and regions that the base cannot leave.

pub(crate) mod base_enclosure;
pub(crate) mod lower_bound;
mod pose_clusters;
mod pose_functional;
mod sliding_base;
