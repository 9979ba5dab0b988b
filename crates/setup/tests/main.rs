//! What is found out about robots from their URDFs.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod built_in;
mod windows;
