//! Intervals of real numbers with ends in `f64`, rounded outwards: inequalities (1) and (2) of `docs/certificate.md`.

use std::ops::{Add, Mul, Neg, Sub};

/// Closed interval. One with an infinite end contains every real number: no inequality that needs it can be proven.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Interval {
    pub lo: f64,
    pub hi: f64,
}

/// Magnitude from which on a result counts as unknown.
const LARGEST: f64 = 1e150;

pub const ZERO: Interval = point(0.0);
pub const ONE: Interval = point(1.0);
const UNKNOWN: Interval = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

/// Returns the interval of one number.
pub const fn point(x: f64) -> Interval {
    Interval { lo: x, hi: x }
}

impl Interval {
    /// Returns the interval of these ends; the unknown one if an end is not a number of usable size.
    fn of(lo: f64, hi: f64) -> Self {
        if lo >= -LARGEST && hi <= LARGEST && lo <= hi { Self { lo, hi } } else { UNKNOWN }
    }

    pub fn middle(self) -> f64 {
        0.5 * (self.lo + self.hi)
    }

    pub fn magnitude(self) -> Self {
        let least = self.lo.max(-self.hi).max(0.0);
        Self::of(least, self.hi.max(-self.lo))
    }

    pub fn max(self, other: Self) -> Self {
        Self::of(self.lo.max(other.lo), self.hi.max(other.hi))
    }

    pub fn square(self) -> Self {
        let m = self.magnitude();
        m * m
    }

    /// Returns the root of the part that is not negative.
    pub fn sqrt(self) -> Self {
        let end = |x: f64| x.max(0.0).sqrt();
        Self::of(end(self.lo).next_down().max(0.0), end(self.hi).next_up())
    }

    /// Returns the quotient by an interval of positive numbers; the unknown interval for any other divisor.
    pub fn over(self, divisor: Self) -> Self {
        if divisor.lo <= 0.0 || !divisor.hi.is_finite() {
            return UNKNOWN;
        }
        let ends = [self.lo / divisor.lo, self.lo / divisor.hi, self.hi / divisor.lo, self.hi / divisor.hi];
        if self == ZERO { ZERO } else { around(ends) }
    }

    /// Encloses sine and cosine (2).
    ///
    /// 1. Of the middle x: x = k·π/2 + r with |r| ≤ 0.79, π/2 = C₁ + C₂ + C₃, where k·C₁ and k·C₂ are exact.
    /// 2. Taylor polynomials of r in nested form, and the first term left out.
    /// 3. Both change by no more than their argument.
    pub fn sin_cos(self) -> [Self; 2] {
        const C1: f64 = f64::from_bits(0x3FF921FB54400000);
        const C2: f64 = f64::from_bits(0x3DD0B4611A600000);
        const C3: f64 = f64::from_bits(0x3BA3198A2E037073);
        let x = self.middle();
        let k = (x * std::f64::consts::FRAC_2_PI).round();
        let c3 = Self { lo: C3.next_down(), hi: C3.next_up() };
        let r = (point(x) - point(k * C1)) - point(k * C2) - point(k) * c3;
        if !(k.abs() <= 1_048_576.0 && r.magnitude().hi <= 0.79) {
            return [UNKNOWN; 2];
        }
        let square = r.square();
        let term = |inner: Self, i: u32| ONE - (square * inner).over(point(f64::from(i * (i - 1))));
        let nested = |first: u32, last: u32| (first..=last).rev().step_by(2).fold(ONE, term);
        let within = |most: f64| Self::of(-most, most);
        let half_width = within((self - point(x)).magnitude().hi);
        let sine = r * nested(3, 15) + within(6e-17) + half_width;
        let cosine = nested(2, 16) + within(3e-18) + half_width;
        let by_quadrant = [[sine, cosine], [cosine, -sine], [-sine, -cosine], [-cosine, sine]];
        by_quadrant[k.rem_euclid(4.0) as usize]
    }
}

/// Returns the least interval of neighbouring numbers around four candidates.
fn around(ends: [f64; 4]) -> Interval {
    let is_number = !ends.iter().any(|end| end.is_nan());
    let lo = ends.into_iter().fold(f64::INFINITY, f64::min);
    let hi = ends.into_iter().fold(f64::NEG_INFINITY, f64::max);
    if is_number { Interval::of(lo.next_down(), hi.next_up()) } else { UNKNOWN }
}

/// Returns the sum and its rounding error, exact unless it overflows (Knuth's two-sum).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

impl Add for Interval {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let ((lo, lo_error), (hi, hi_error)) = (two_sum(self.lo, other.lo), two_sum(self.hi, other.hi));
        let (below, above) = (lo.next_down(), hi.next_up());
        Self::of(if lo_error == 0.0 { lo } else { below }, if hi_error == 0.0 { hi } else { above })
    }
}

impl Neg for Interval {
    type Output = Self;
    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }
}

impl Sub for Interval {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        if (self == ZERO && other != UNKNOWN) || (other == ZERO && self != UNKNOWN) {
            return ZERO;
        }
        around([self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi])
    }
}

/// Vector of intervals.
pub type Vector = [Interval; 3];

/// Rotation matrix of intervals, by rows.
pub type Matrix = [Vector; 3];

pub const ORIGIN: Vector = [ZERO; 3];
pub const IDENTITY: Matrix = [[ONE, ZERO, ZERO], [ZERO, ONE, ZERO], [ZERO, ZERO, ONE]];

pub fn dot(a: Vector, b: Vector) -> Interval {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn length(a: Vector) -> Interval {
    (a[0].square() + a[1].square() + a[2].square()).sqrt()
}

pub fn sum(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] + b[i])
}

pub fn minus(a: Vector) -> Vector {
    a.map(|x| -x)
}

pub fn scaled(a: Vector, by: Interval) -> Vector {
    a.map(|x| x * by)
}

pub fn times(m: &Matrix, v: Vector) -> Vector {
    std::array::from_fn(|row| dot(m[row], v))
}

/// Returns the product of the transposed matrix and the vector.
pub fn transposed_times(m: &Matrix, v: Vector) -> Vector {
    std::array::from_fn(|column| m[0][column] * v[0] + m[1][column] * v[1] + m[2][column] * v[2])
}

pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|row| transposed_times(b, a[row]))
}
