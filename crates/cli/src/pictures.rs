//! `cranny render`, `cranny sense` and `cranny view`: pictures, what cameras see, and pages.

pub(crate) mod page_task;
pub(crate) mod render;
pub(crate) mod render_film;
pub(crate) mod render_format;
pub(crate) mod render_sheet;
pub(crate) mod robot_picture;
pub(crate) mod search_replay;
pub(crate) mod sense;
pub(crate) mod view;
