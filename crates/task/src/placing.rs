//! The object in the hand and its placements.

pub(crate) mod carry;
pub(crate) mod place;
pub(crate) mod place_goal;
pub(crate) mod placed;
pub(crate) mod placement;
pub(crate) mod rests;
