/// Formats numbers for one message with `decimals` decimals, or with as many more as unequal numbers need to differ in print: a
/// start of −2.00001 beside a limit of −2 is not "−2.0000 outside −2.0000".
///
/// `distinct(x, d)[i] = distinct(x, d)[j]` only where `x[i] = x[j]`, or one of them is NaN.
pub fn distinct<const N: usize>(numbers: [f64; N], decimals: usize) -> [String; N] {
    /// Number of decimals that distinguishes all numbers that occur in messages.
    const MOST: usize = 17;
    let printed = |decimals: usize| numbers.map(|number| format!("{number:.decimals$}"));
    let differ = |texts: &[String; N]| {
        (0..N).all(|i| {
            (0..i).all(|j| {
                let are_equal = numbers[i].partial_cmp(&numbers[j]).is_none_or(std::cmp::Ordering::is_eq);
                are_equal || texts[i] != texts[j]
            })
        })
    };
    let enough = (decimals..MOST).map(printed).find(differ);
    // Numbers that differ by less are printed with all their digits.
    enough.unwrap_or_else(|| numbers.map(|number| format!("{number:?}")))
}

#[cfg(test)]
mod tests {
    use super::distinct;

    #[test]
    fn unequal_numbers_look_unequal() {
        assert_eq!(distinct([-2.000_01, -2.0, 2.0], 4), ["-2.00001", "-2.00000", "2.00000"]);
        assert_eq!(distinct([80.049, 80.0], 1), ["80.05", "80.00"]);
        assert_eq!(distinct([0.5, 0.5], 2), ["0.50", "0.50"]);
        assert_eq!(distinct([1.0, f64::NAN], 2), ["1.00", "NaN"]);
        let next = f64::from_bits(1.0_f64.to_bits() + 1);
        let [first, second] = distinct([1.0, next], 0);
        assert_ne!(first, second);
        let [first, second] = distinct([1e-30, 2e-30], 3);
        assert_ne!(first, second);
    }
}
