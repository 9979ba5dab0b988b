//! Integration tests of this crate as one program, which is linked once.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod ball_trees;
mod cancelled_windings;
mod closest;
mod collada_files;
mod contact;
mod large_hulls;
mod large_meshes;
mod mesh_files;
mod objects;
mod separation;
