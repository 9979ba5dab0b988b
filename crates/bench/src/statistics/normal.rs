use std::f64::consts::SQRT_2;

/// The 0.975 quantile of the standard normal distribution: what all intervals of 95 % are made with.
pub const Z_95: f64 = 1.959963984540054;

/// How probable it is that a standard normal variable lies as far from zero as `z`, or farther.
///
/// `p = erfc(|z| / √2)`; for a chi-square statistic of one degree of freedom `z` is its square root.
pub fn two_sided_p(z: f64) -> f64 {
    libm::erfc(z.abs() / SQRT_2)
}
