//! Data and server of the viewer page.

pub(crate) mod number_row;
pub(crate) mod page;
pub(crate) mod page_answer;
pub(crate) mod page_bundle;
pub(crate) mod page_cells;
pub(crate) mod page_feed;
pub(crate) mod page_file;
pub(crate) mod page_grasps;
pub(crate) mod page_plan;
pub(crate) mod page_recording;
pub(crate) mod page_robot;
pub(crate) mod page_scene;
pub(crate) mod page_server;
pub(crate) mod page_task;
pub(crate) mod verdict;
pub(crate) mod watched_search;
pub(crate) mod watched_tree;
pub(crate) mod welding;
