//! Integration tests of this crate as one program, which is linked once.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod acronym;
mod arrays;
mod imports;
mod metrics;
mod records;
mod released_grasps;
mod sampling;
