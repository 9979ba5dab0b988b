//! Integration tests of the setup of robots from their URDFs.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod built_in;
mod pipes;
mod windows;
