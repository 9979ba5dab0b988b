//! Search for a path through the stages of a task.

mod approach;
pub(crate) mod chain;
mod effort;
mod later_stage_checks;
pub(crate) mod onward;
mod place_search;
mod refusals;
