//! All tests of this crate from outside: one program, which is linked once.

mod experiment;
mod grasps;
mod inputs;
mod plans;
