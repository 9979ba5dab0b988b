//! All integration tests of this crate, in one program that is linked once.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod fixture;
mod synthetic;

mod campaign_file;
mod few_runs;
mod hostile_names;
mod hostile_results;
mod large_reports;
mod merging;
mod ompl_log;
mod report;
mod report_page;
mod report_warnings;
mod results;
mod shards;
mod statistics;
#[cfg(unix)]
mod workers;
