//! Collision pairs: checked pairs, exempt pairs, and the nearest pair.

pub(crate) mod closest;
pub(crate) mod demanded_pair;
pub(crate) mod exempt_pair;
pub(crate) mod lone_hand;
pub(crate) mod pair_choice;
pub(crate) mod pair_distance;
pub(crate) mod pair_group;
pub(crate) mod pair_range;
pub(crate) mod pairs;
pub(crate) mod self_pairs;
