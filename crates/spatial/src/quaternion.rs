use nalgebra::Quaternion;

use crate::Rotation;

/// Maximum difference of a quaternion's length from 1; printing with four digits causes less.
const TOLERANCE: f64 = 1e-3;

/// Returns the rotation of a quaternion (x, y, z, w) of unit length.
///
/// # Errors
/// The length, if it is not 1 within 0.001.
pub fn rotation_from_xyzw([x, y, z, w]: [f64; 4]) -> Result<Rotation, f64> {
    let quaternion = Quaternion::new(w, x, y, z);
    let norm = quaternion.norm();
    let is_unit = (norm - 1.0).abs() <= TOLERANCE;
    is_unit.then(|| Rotation::from_quaternion(quaternion)).ok_or(norm)
}
