//! How numbers stand in tables.

/// About three digits that mean something, never an exponent: `0.00123`, `1.23`, `12.35`, `123.5`, `1235`.
pub fn plain(value: f64) -> String {
    let size = value.abs();
    let decimals = match size {
        s if s == 0.0 || s >= 1000.0 => 0,
        s if s >= 100.0 => 1,
        s if s >= 1.0 => 2,
        s => digits_after_point(s, 3),
    };
    format!("{value:.decimals$}")
}

/// Seconds as the paper's table has them, with two decimals; with two digits where those would say nothing.
pub fn table_seconds(seconds: f64) -> String {
    let decimals =
        if seconds == 0.0 || seconds.abs() >= 0.095 { 2 } else { digits_after_point(seconds.abs(), 2) };
    format!("{seconds:.decimals$}")
}

/// A share as a percentage, without a decimal where it is whole.
pub fn percent(share: f64) -> String {
    let percent = share * 100.0;
    if (percent - percent.round()).abs() < 1e-9 { format!("{percent:.0}") } else { format!("{percent:.1}") }
}

/// Decimals that show `digits` digits of a value below 1.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn digits_after_point(size: f64, digits: i32) -> usize {
    // Below a millionth nothing is measured here.
    (digits - 1 - size.log10().floor().max(-6.0) as i32).max(0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_mean_something() {
        let texts = [0.0, 0.001234, 0.0999, 1.234, 12.345, 123.45, 1234.5, -0.5, 1e-9].map(plain);
        assert_eq!(
            texts,
            ["0", "0.00123", "0.0999", "1.23", "12.35", "123.5", "1234", "-0.500", "0.00000000"]
        );
        assert_eq!(
            [10.53, 0.011, 0.0023, 0.0, 604.377].map(table_seconds),
            ["10.53", "0.011", "0.0023", "0.00", "604.38"]
        );
        assert_eq!([1.0, 0.91, 0.955].map(percent), ["100", "91", "95.5"]);
    }
}
