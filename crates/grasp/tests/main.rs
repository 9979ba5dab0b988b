//! All tests of this crate from outside: one program, which is linked once.

mod metrics;
mod released_grasps;
mod sampling;
