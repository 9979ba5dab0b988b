#![doc = include_str!("../README.md")]

mod ball_pack;
mod batch;
mod bubble;
mod cell;
mod cell_parts;
mod closest;
mod closing;
mod contact;
mod error;
mod held_body;
mod holding;
mod joint_table;
mod lane_ball;
mod lane_bits;
mod lane_body;
mod lane_hull;
mod lane_links;
mod lane_part;
mod lane_scratch;
mod lane_tree;
mod lane_vector;
mod lane_world;
mod lanes;
mod link_balls;
mod link_body;
mod link_sweep;
mod margins;
mod measured_motion;
mod motion;
mod pair_choice;
mod pairs;
mod part_tree;
mod path_clearance;
mod released;
mod resting;
mod robot_body;
mod self_pairs;
mod single_frame;
mod single_lane;
mod travel;
mod unchecked;
mod work_list;
mod world;
mod world_clearance;

mod lane_solid;
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
