//! All tests of this crate from outside: one program, which is linked once.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod moveit_folder;
mod released_object;

mod alteration;
mod bad_input;
mod blends;
mod built_in;
mod built_in_robot;
mod burs;
mod cancelled_windings;
mod carrying;
mod checking;
mod contact;
mod families;
mod grasp_sampling;
mod identity;
mod ik_statuses;
mod lanes;
mod moveit;
mod moveit_forms;
mod moveit_robot;
mod objects;
mod old_formats;
mod other_robots;
mod own_layout;
mod placing;
mod quicker;
mod released_layout;
mod round_trip;
mod sharing;
mod statements;
mod target_object;
mod tasks;
mod twenty;
