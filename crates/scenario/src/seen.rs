//! Scenarios whose obstacles are what cameras have seen.

pub(crate) mod seen_entry;
pub(crate) mod seen_folder;
pub(crate) mod seen_space;
pub(crate) mod with_seen;
