//! Is this configuration free, is this whole motion free, and by how much?
//!
//! A [`Cell`] is a robot in a [`World`]. Its answers are the reference that every faster check is held to:
//! distances in `f64` between the real shapes, links as solids, obstacles as solids. Where a distance
//! matters it is the certified lower bound of [`cranny_shape::separation`], so "free" is never a rounding
//! error. [`Cell::motion_is_free`] proves a whole straight edge of configuration space.
//!
//! [`ReleasedCheck`] is the other thing: the loose check of the released planners, for comparison only.
//!
//! All poses are in the planning frame, the root frame of the robot.
//!
//! ## Limits
//! Links that no joint of the group moves are checked against other links but not against the world: where
//! a fixed base stands on its table is not for a planner to decide. What touches and is not checked is said:
//! [`Cell::unchecked`]. Joint paths are straight lines in
//! configuration space; other curves are proven piece by piece. Nothing here deforms.

mod ball_pack;
mod batch;
mod bubble;
mod cell;
mod cell_parts;
mod closest;
mod closing;
mod contact;
mod error;
mod holding;
mod joint_table;
mod lane_body;
mod lane_hull;
mod lane_links;
mod lane_part;
mod lane_scratch;
mod lane_tree;
mod lane_world;
mod lanes;
mod link_balls;
mod link_body;
mod link_sweep;
mod margins;
mod measured_motion;
mod motion;
mod pairs;
mod part_tree;
mod path_clearance;
mod released;
mod resting;
mod robot_body;
mod self_pairs;
mod single_lane;
mod travel;
mod unchecked;
mod world;
mod world_clearance;

#[cfg(test)]
mod lane_tests;
#[cfg(test)]
mod proof_tests;

pub use bubble::Bubble;
pub use cell::{Cell, Scratch};
pub use closest::Closest;
pub use closing::Closing;
pub use contact::{Collider, Contact};
pub use error::CollisionError;
pub use margins::Margins;
pub use measured_motion::{MeasuredMotion, Measuring};
pub use motion::Motion;
pub use released::{ReleasedCheck, ReleasedScratch};
pub use resting::Resting;
pub use unchecked::{Unchecked, UncheckedReason};
pub use world::{Body, Part, World};
