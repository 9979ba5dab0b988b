//! Collision pairs: the ones that are checked, the ones that are exempt, and the nearest one.

pub(crate) mod closest;
pub(crate) mod pair_choice;
pub(crate) mod pair_group;
pub(crate) mod pair_range;
pub(crate) mod pairs;
pub(crate) mod self_pairs;
pub(crate) mod unchecked;
