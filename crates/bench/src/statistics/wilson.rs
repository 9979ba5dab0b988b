use crate::statistics::{Interval, Z_95};

/// Computes the score interval of a rate with `successes` in `trials`; `None` without trials.
///
/// It contains the rate itself, lies in [0, 1], and keeps its level for rates near 0 and 1, where the textbook's
/// `p ± z √(p(1 − p)/n)` has no width.
///
/// # Panics
/// If there are more successes than trials.
///
/// Source: Wilson 1927, "Probable inference, the law of succession, and statistical inference", whole; as method 3 in
/// Newcombe 1998, "Two-sided confidence intervals for the single proportion", eq. (3).
pub fn wilson(successes: usize, trials: usize) -> Option<Interval> {
    assert!(successes <= trials, "{successes} successes in {trials} trials");
    if trials == 0 {
        return None;
    }
    let (n, z2) = (trials as f64, Z_95 * Z_95);
    let rate = successes as f64 / n;
    let middle = (rate + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = Z_95 * (rate * (1.0 - rate) / n + z2 / (4.0 * n * n)).sqrt() / (1.0 + z2 / n);
    // At the ends the two terms are equal except for rounding.
    let low = if successes == 0 { 0.0 } else { middle - half };
    let high = if successes == trials { 1.0 } else { middle + half };
    Some(Interval { low, high })
}
