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
    (trials > 0).then(|| wilson_of_share(successes as f64 / trials as f64, trials as f64))
}

/// Computes the score interval of a rate in [0, 1] with the precision of `trials` > 0 trials, which need not be a whole number.
pub(super) fn wilson_of_share(rate: f64, trials: f64) -> Interval {
    let (n, z2) = (trials, Z_95 * Z_95);
    let middle = (rate + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = Z_95 * (rate * (1.0 - rate) / n + z2 / (4.0 * n * n)).sqrt() / (1.0 + z2 / n);
    // At the ends the two terms are equal except for rounding.
    let low = if rate <= 0.0 { 0.0 } else { middle - half };
    let high = if rate >= 1.0 { 1.0 } else { middle + half };
    Interval { low, high }
}
