//! How well planners do: campaigns of trials that survive whatever a planner does, judged alike, stored as
//! they come, told with their uncertainty.
//!
//! ## Limits
//! One machine runs one campaign; results of several are joined afterwards.

pub mod statistics;

mod trial;

pub use trial::{Trial, TrialOutcome, TrialRecord};
