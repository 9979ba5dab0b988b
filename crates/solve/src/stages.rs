//! Search for a path through the stages of a task.

mod approach;
pub(crate) mod chain;
mod effort;
mod later_stage_checks;
mod later_stages;
pub(crate) mod onward;
mod place_search;
mod refusals;
