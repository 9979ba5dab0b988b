/// The 0.975 quantile of the standard normal distribution, of intervals of 95 % for large samples.
pub const Z_95: f64 = 1.959963984540054;
