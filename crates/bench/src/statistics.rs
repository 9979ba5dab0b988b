//! The statistics of runs that may be cut short: rates, times, their uncertainty, and who is faster.
//!
//! A trial that was stopped at its limit has no time, but it is no lost trial either: it is *censored*, known
//! to take longer than it was given. All intervals are of 95 %.

mod holm;
mod kaplan_meier;
mod log_rank;
mod normal;
mod performance_profile;
mod restricted_mean;
mod sample_moments;
mod spread;
mod wilson;

pub use holm::holm;
pub use kaplan_meier::{Followed, KaplanMeier, SurvivalStep};
pub use log_rank::{LogRank, log_rank};
pub use normal::{Z_95, two_sided_p};
pub use performance_profile::{PerformanceProfile, performance_profiles};
pub use restricted_mean::{MeanDifference, RestrictedMean};
pub use sample_moments::SampleMoments;
pub use spread::Spread;
pub use wilson::wilson;

/// From where to where a figure lies, with 95 % confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}
