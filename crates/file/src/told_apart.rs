/// Two numbers with the same number of decimals: `least`, or as many more as it takes to tell unequal ones apart.
pub fn told_apart(numbers: [f64; 2], least: usize) -> [String; 2] {
    /// The shortest text that gives an `f64` back has at most as many significant digits.
    const MOST: usize = 17;
    let [a, b] = numbers;
    let texts = |decimals: usize| numbers.map(|number| format!("{number:.decimals$}"));
    let differ = |texts: &[String; 2]| texts[0] != texts[1];
    match (least..=MOST.max(least)).map(texts).find(differ) {
        Some(texts) if a != b => texts,
        _ if a == b => texts(least),
        _ => numbers.map(|number| format!("{number:e}")),
    }
}

#[cfg(test)]
mod tests {
    use super::told_apart;

    #[test]
    fn unequal_numbers_get_as_many_digits_as_it_takes() {
        assert_eq!(told_apart([80.0, 80.0], 1), ["80.0", "80.0"]);
        assert_eq!(told_apart([80.000_4, 80.0], 1), ["80.0004", "80.0000"]);
        assert_eq!(told_apart([-2.000_01, -2.0], 4), ["-2.00001", "-2.00000"]);
        assert_eq!(told_apart([1e-30, 2e-30], 2), ["1e-30", "2e-30"]);
        let next = f64::from_bits(80.0_f64.to_bits() + 1);
        let [a, b] = told_apart([next, 80.0], 1);
        assert_ne!(a, b);
    }
}
