//! Numbers on the command line, each with its range: what is outside of it is refused in one line that says it.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::time::Duration;

use cranny_solve::PoseRadius;

/// No search of anybody's goes on for longer, in seconds (116 days), and no clock overflows before.
pub const MOST_SECONDS: f64 = cranny_bench::MOST_TIME_LIMIT_S;

/// As many iterations as a file of results can hold.
pub const MOST_ITERATIONS: u64 = i64::MAX.cast_unsigned();

/// Parses whole numbers of a range.
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

/// A factor.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "give a positive number".to_owned())
}

/// A factor that makes nothing larger.
pub fn share(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && *number <= 1.0);
    number.ok_or_else(|| "give a number greater than 0, at most 1".to_owned())
}

/// A length of at least 0 in millimetres, in metres.
pub fn millimetres(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.map(|number| number / 1000.0).ok_or_else(|| "give millimetres, at least 0".to_owned())
}

/// Millimetres and degrees.
pub fn pose_error(text: &str) -> Result<PoseRadius, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[mm, degrees]) if (0.0..=1000.0).contains(&mm) && (0.0..=180.0).contains(&degrees) => {
            Ok(PoseRadius { translation_m: mm / 1e3, rotation_rad: degrees.to_radians() })
        }
        _ => Err("give millimetres from 0 to 1000 and degrees from 0 to 180, such as 2,3".to_owned()),
    }
}

/// A time limit.
pub fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=MOST_SECONDS).contains(seconds));
    let duration = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    duration.ok_or_else(|| format!("give a number of seconds from 0 to {MOST_SECONDS}"))
}
