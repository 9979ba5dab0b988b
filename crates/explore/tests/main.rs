//! Tests of the crate.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "tests")]

mod next_views;
mod scene;
mod swept;
