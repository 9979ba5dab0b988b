//! Statistics of censored runs: rates, times, their uncertainty, and comparisons of planners.
//!
//! A trial that was stopped at its limit has no time, but it is no lost trial either: it is *censored*, known to take
//! longer than its limit. All intervals are of 95 %.

mod division;
mod five_numbers;
mod holm;
mod kaplan_meier;
mod log_rank;
mod mean_rate;
mod mean_survival;
mod median_interval;
mod normal;
mod performance_profile;
mod ranking;
mod restricted_mean;
mod sample_moments;
mod two_sample_test;
mod wilson;

pub use five_numbers::FiveNumbers;
pub use holm::holm;
pub use kaplan_meier::{Followed, KaplanMeier, SurvivalStep};
pub use log_rank::{LogRank, log_rank};
pub use mean_rate::mean_rate;
pub use mean_survival::{MeanStep, MeanSurvival};
pub use median_interval::{LEAST_FOR_MEDIAN, median_interval};
pub use normal::Z_95;
pub use performance_profile::{PerformanceProfile, performance_profiles};
pub use ranking::area_under_curve;
pub use restricted_mean::RestrictedMean;
pub use sample_moments::SampleMoments;
pub use two_sample_test::{TwoSampleTest, least_p};
pub use wilson::wilson;

/// Level of all tests, and probability that an interval misses.
pub const LEVEL: f64 = 0.05;

/// Interval that contains a figure with 95 % confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}
