//! All tests of this crate from outside: one program, which is linked once.

mod ball_trees;
mod cancelled_windings;
mod closest;
mod contact;
mod large_hulls;
mod mesh_files;
mod objects;
mod separation;
