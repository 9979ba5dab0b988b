//! Numbers on the command line; an error of one line states the valid range.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::time::Duration;

use cranny_solve::PoseRadius;

/// Maximum time limit of any search, in seconds (116 days); clocks do not overflow below it.
pub const MOST_SECONDS: f64 = cranny_bench::MOST_TIME_LIMIT_S;

/// Maximum number of iterations that a file of results can store.
pub const MOST_ITERATIONS: u64 = i64::MAX.cast_unsigned();

/// Returns a parser of integers within a range.
pub fn whole<T>(
    range: RangeInclusive<T>,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: std::str::FromStr + PartialOrd + Display + Clone + Send + Sync + 'static,
{
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("give a whole number from {} to {}", range.start(), range.end()))
    }
}

/// Parses a finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("'{text}' is no finite number"))
}

/// Parses a positive factor.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "give a positive number".to_owned())
}

/// Parses a factor above 0 and at most 1.
pub fn share(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && *number <= 1.0);
    number.ok_or_else(|| "give a number greater than 0, at most 1".to_owned())
}

/// Parses a share from 0 to 1.
pub fn share_or_none(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| (0.0..=1.0).contains(number));
    number.ok_or_else(|| "give a number from 0 to 1".to_owned())
}

/// Parses a length in millimetres, at least 0, and returns metres.
pub fn millimetres(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.map(|number| number / 1000.0).ok_or_else(|| "give millimetres, at least 0".to_owned())
}

/// Parses a pose error in millimetres and degrees.
pub fn pose_error(text: &str) -> Result<PoseRadius, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[mm, degrees]) if (0.0..=1000.0).contains(&mm) && (0.0..=180.0).contains(&degrees) => {
            Ok(PoseRadius { translation_m: mm / 1e3, rotation_rad: degrees.to_radians() })
        }
        _ => Err("give millimetres from 0 to 1000 and degrees from 0 to 180, such as 2,3".to_owned()),
    }
}

/// Parses a time limit in seconds.
pub fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=MOST_SECONDS).contains(seconds));
    let duration = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    duration.ok_or_else(|| format!("give a number of seconds from 0 to {MOST_SECONDS}"))
}
