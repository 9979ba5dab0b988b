//! All integration tests of this crate in one program, which is linked once.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod fixture;

mod bad_input;
mod closest;
mod distances;
mod grazing;
mod holding;
mod many_parts;
mod margins;
mod motions;
mod released_check;
mod resting;
mod resting_faces;
mod robot_bodies;
mod self_pairs;
mod tool_bounds;
