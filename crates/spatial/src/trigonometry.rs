/// Returns sine and cosine of `angle` (radians), from one library on every platform, so that a search takes the same branches
/// everywhere.
pub fn sin_cos(angle: f64) -> (f64, f64) {
    libm::sincos(angle)
}
