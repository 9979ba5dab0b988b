//! External tests of this crate, in one program, which is linked once.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod moveit_folder;
mod released_object;

mod alteration;
mod bad_input;
mod built_in;
mod built_in_robot;
mod burs;
mod checking;
mod cloud_obstacles;
mod families;
mod gradients;
mod grasp_sampling;
mod identity;
mod moveit_forms;
mod moveit_octomap;
mod moveit_robot;
mod objects;
mod other_robots;
mod own_layout;
mod round_trip;
mod sharing;
mod target_object;
mod twenty;
