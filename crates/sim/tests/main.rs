//! All integration tests of this crate in one binary, which is linked once.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod experiment;
mod grasps;
mod inputs;
mod plans;
mod rest;
