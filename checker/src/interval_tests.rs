//! Laws of the arithmetic, against whole numbers and against the identities of sine and cosine.

use super::interval::{Interval, ONE, point};

/// Numbers from a seed, spread over many magnitudes (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E3779B97F4A7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58476D1CE4E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D049BB133111EB);
        z ^ z >> 31
    }

    /// Returns a whole number of up to 60 bits.
    fn whole(&mut self) -> i128 {
        let bits = self.next() % 60;
        let magnitude = i128::from(self.next() & ((1 << bits) - 1));
        if self.next() & 1 == 1 { magnitude } else { -magnitude }
    }
}

/// Returns true if the interval contains p/q (q > 0): the sign of a fused product and sum is exact.
fn contains(interval: Interval, p: f64, q: f64) -> bool {
    interval.lo.mul_add(q, -p) <= 0.0 && interval.hi.mul_add(q, -p) >= 0.0
}

#[test]
fn sums_and_products_of_whole_numbers_are_enclosed() {
    let mut numbers = Numbers(1);
    for _ in 0..200_000 {
        let (a, b) = (numbers.whole(), numbers.whole() >> 20);
        // Rounded to `f64` first: the law is about numbers that it has.
        let (a, b) = ((a as f64) as i128, (b as f64) as i128);
        let (x, y) = (point(a as f64), point(b as f64));
        for (interval, exact) in [(x + y, a + b), (x - y, a - b), (x * y, a * b), (x.square(), a * a)] {
            assert!(interval.lo as i128 <= exact && exact <= interval.hi as i128, "{a} {b}: {interval:?}");
        }
        let root = x.magnitude().sqrt();
        assert!(root.square().lo as i128 <= a.abs() && a.abs() <= root.square().hi as i128);
        if b > 0 {
            assert!(contains(x.over(y), a as f64, b as f64), "{a} / {b}: {:?}", x.over(y));
        }
    }
}

#[test]
fn sine_and_cosine_are_enclosed_narrowly() {
    let mut numbers = Numbers(2);
    for _ in 0..200_000 {
        let x = numbers.whole() as f64 / (1_u64 << 55) as f64 * 40.0;
        let [sine, cosine] = point(x).sin_cos();
        let one = sine.square() + cosine.square();
        assert!(one.lo <= 1.0 && 1.0 <= one.hi);
        for (enclosure, value) in [(sine, x.sin()), (cosine, x.cos())] {
            // The library of the system is right to one unit in the last place.
            assert!(enclosure.lo <= value.next_up() && value.next_down() <= enclosure.hi, "{x}");
            assert!(enclosure.hi - enclosure.lo < 4e-15, "{x}: {enclosure:?}");
        }
        // Both addition theorems, at an interval.
        let [twice, _] = (point(x) + point(x)).sin_cos();
        let by_theorem = point(2.0) * sine * cosine;
        assert!(twice.lo <= by_theorem.hi && by_theorem.lo <= twice.hi, "{x}");
        let wide = Interval { lo: x, hi: x + 0.01 };
        let [sine, cosine] = wide.sin_cos();
        for share in [0.0, 0.3, 1.0] {
            let y = x + 0.01 * share;
            assert!(sine.lo <= y.sin() && y.sin() <= sine.hi && cosine.lo <= y.cos() && y.cos() <= cosine.hi);
        }
    }
}

#[test]
fn what_is_no_number_proves_nothing() {
    let nothing = point(f64::NAN) + ONE;
    for unknown in [nothing, nothing * point(0.0), point(f64::INFINITY) * ONE.square(), ONE.over(point(0.0))]
    {
        let unknown = unknown + ONE;
        assert!(unknown.lo == f64::NEG_INFINITY && unknown.hi == f64::INFINITY, "{unknown:?}");
        let [sine, _] = unknown.sin_cos();
        assert!(sine.lo <= -1.0 && sine.hi >= 1.0);
    }
}
