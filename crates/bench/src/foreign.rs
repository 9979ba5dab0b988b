//! External planners: files, processes, isolation and answers.

pub(crate) mod enclosure;
pub(crate) mod foreign_answer;
pub(crate) mod foreign_planner;
pub(crate) mod foreign_process;
pub(crate) mod problem_folder;
pub(crate) mod process_group;
pub(crate) mod sandbox;
mod supported;
pub(crate) mod written_files;
