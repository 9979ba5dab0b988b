//! Formatting of numbers in tables.

/// Formats with about three significant digits, never an exponent: `0.00123`, `1.23`, `12.35`, `123.5`, `1235`.
pub fn plain(value: f64) -> String {
    let size = value.abs();
    let decimals = match size {
        s if !(LEAST..1000.0).contains(&s) => 0,
        s if s >= 100.0 => 1,
        s if s >= 1.0 => 2,
        s => digits_after_point(s, 3),
    };
    format!("{value:.decimals$}")
}

/// Formats seconds as in the paper's table, with two decimals; with two significant digits if those decimals would be zero.
pub fn table_seconds(seconds: f64) -> String {
    let size = seconds.abs();
    let decimals = if (LEAST..0.095).contains(&size) { digits_after_point(size, 2) } else { 2 };
    format!("{seconds:.decimals$}")
}

/// Formats a share as a percentage, without a decimal if it is whole.
pub fn percent(share: f64) -> String {
    let percent = share * 100.0;
    if (percent - percent.round()).abs() < 1e-9 { format!("{percent:.0}") } else { format!("{percent:.1}") }
}

/// Threshold below which a value is shown as zero; no measurement here resolves a tenth of a millionth.
const LEAST: f64 = 1e-7;

/// Returns the number of decimals that show `digits` digits of a value from [`LEAST`] to 1.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a count that is not negative and small"
)]
fn digits_after_point(size: f64, digits: i32) -> usize {
    (digits - 1 - size.log10().floor() as i32).max(0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_mean_something() {
        let texts = [0.0, 0.001234, 0.0999, 1.234, 12.345, 123.45, 1234.5, -0.5, 1e-9].map(plain);
        assert_eq!(texts, ["0", "0.00123", "0.0999", "1.23", "12.35", "123.5", "1234", "-0.500", "0"]);
        assert_eq!(
            [10.53, 0.011, 0.0023, 0.0, 604.377, 2.8e-17, 2.3e-6].map(table_seconds),
            ["10.53", "0.011", "0.0023", "0.00", "604.38", "0.00", "0.0000023"]
        );
        assert_eq!([1.0, 0.91, 0.955].map(percent), ["100", "91", "95.5"]);
    }
}
