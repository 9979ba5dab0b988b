//! Integration tests of this crate, in one program that is linked once.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod base_enclosure;
mod blends;
mod cancelled_windings;
mod carrying;
mod contact;
mod ik_statuses;
mod lanes;
mod lower_bound;
mod moveit;
mod old_formats;
mod placing;
mod quicker;
mod regions;
mod released_layout;
mod statements;
mod straight;
mod tasks;
mod tool_bounds;
mod torque;
mod upright;
