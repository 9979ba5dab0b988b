//! All integration tests of this crate in one binary, which is linked once.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod carrying;
mod many_bodies;
mod page_data;
mod page_server;
mod pictures;
mod placing;
mod recordings;
mod scenes;
mod stages;
