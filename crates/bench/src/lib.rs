//! How well planners do: campaigns of trials that survive whatever a planner does, judged alike, stored as
//! they come, told with their uncertainty.
//!
//! ## Limits
//! One machine runs one campaign; results of several are joined afterwards.

pub mod report;
pub mod statistics;

mod error;
mod ompl_log;
mod results;
mod results_row;
mod run_information;
mod trial;

pub use error::BenchError;
pub use ompl_log::OmplLog;
pub use results::{Merged, Results, Run, ScenarioSource, StoredTrial};
pub use run_information::RunInformation;
pub use trial::{Trial, TrialOutcome, TrialRecord};
