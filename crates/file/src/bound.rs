/// Formats a lower bound, converted to a unit `per_unit` times smaller, as decimal text: never above the bound.
pub fn at_least(bound: f64, per_unit: f64, digits: usize) -> String {
    rounded(bound, per_unit, digits, -1.0)
}

/// Formats an upper bound, converted to a unit `per_unit` times smaller, as decimal text: never below the bound.
pub fn at_most(bound: f64, per_unit: f64, digits: usize) -> String {
    rounded(bound, per_unit, digits, 1.0)
}

/// Returns the nearest decimal, or the next one in the safe direction. The comparison parses the text as a reader would,
/// because the product itself is rounded.
fn rounded(bound: f64, per_unit: f64, digits: usize, direction: f64) -> String {
    let text = unsigned_if_zero(format!("{:.digits$}", bound * per_unit));
    let beyond = |text: &str| text.parse().is_ok_and(|read: f64| (bound - read / per_unit) * direction > 0.0);
    if !beyond(&text) {
        return text;
    }
    let step = direction * 0.1_f64.powi(i32::try_from(digits).unwrap_or(i32::MAX));
    let read: f64 = text.parse().unwrap_or(bound * per_unit);
    unsigned_if_zero(format!("{:.digits$}", read + step))
}

fn unsigned_if_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|digit| digit == b'0' || digit == b'.') => digits.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_is_rounded_to_the_safe_side() {
        for (bound, lower, upper) in [
            (0.004_956_9, "4.95", "4.96"),
            (0.005, "5.00", "5.00"),
            (0.002_29, "2.29", "2.29"),
            (0.000_001, "0.00", "0.01"),
            (0.0, "0.00", "0.00"),
            (0.000_098, "0.09", "0.10"),
            (0.000_009_8, "0.00", "0.01"),
            (-0.000_001, "-0.01", "0.00"),
            (0.999_999_9, "999.99", "1000.00"),
        ] {
            assert_eq!((&*at_least(bound, 1e3, 2), &*at_most(bound, 1e3, 2)), (lower, upper), "{bound}");
        }
        for step in 0..100_000 {
            let bound = f64::from(step) * 1.234_567e-7;
            let [lower, upper] =
                [at_least(bound, 1e3, 2), at_most(bound, 1e3, 2)].map(|text| text.parse::<f64>().unwrap());
            assert!(lower / 1e3 <= bound && bound <= upper / 1e3, "{lower} {bound} {upper}");
            assert!(upper - lower < 0.010_001, "{lower} {upper}");
        }
        assert_eq!(at_least(f64::INFINITY, 1e3, 2), "inf");
    }
}
