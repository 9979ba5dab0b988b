//! All integration tests of this crate, in one program that is linked once.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod fixture;

mod bad_input;
mod building;
mod dynamics;
mod forward_kinematics;
mod free_joints;
mod hands;
mod ik_batch;
mod inverse_kinematics;
mod jacobian;
mod lane_kinematics;
mod large_files;
mod linkage;
mod model_files;
mod reach_bound;
mod urdf_content;
