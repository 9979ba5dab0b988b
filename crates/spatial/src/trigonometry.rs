/// Returns sine and cosine of `angle` (radians), from one library on every platform, so that searches branch alike everywhere.
pub fn sin_cos(angle: f64) -> (f64, f64) {
    libm::sincos(angle)
}
