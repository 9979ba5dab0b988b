use cranny_spatial::nalgebra::{Matrix3, Quaternion, Rotation3, Unit};
use cranny_spatial::{Rotation, Vector, sin_cos};

/// Length below which a direction of a file is zero.
const LEAST_LENGTH: f64 = 1e-10;

/// Returns the shortest rotation from z to `direction`; half a turn about x if it is opposite.
pub(crate) fn rotation_from_z(direction: Vector) -> Option<Rotation> {
    let direction = direction.try_normalize(LEAST_LENGTH)?;
    let axis = Vector::z().cross(&direction);
    let sine = axis.norm();
    let angle = libm::atan2(sine, direction.z);
    let axis = axis.try_normalize(LEAST_LENGTH).unwrap_or_else(Vector::x);
    Some(turn(axis, angle))
}

/// Returns the rotation by `angle` (rad) about a unit vector.
pub(crate) fn turn(axis: Vector, angle: f64) -> Rotation {
    let (sine, cosine) = sin_cos(0.5 * angle);
    Rotation::new_normalize(Quaternion::from_parts(cosine, axis * sine))
}

/// Returns the rotation with this x axis, and a y axis near the given one.
pub(crate) fn rotation_of_axes(x: Vector, y: Vector) -> Option<Rotation> {
    let x = x.try_normalize(LEAST_LENGTH)?;
    let y = (y - x * x.dot(&y)).try_normalize(LEAST_LENGTH)?;
    let axes = Matrix3::from_columns(&[x, y, x.cross(&y)]);
    Some(Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes)))
}

/// Returns the rotation of a quaternion given as w, x, y, z, which need not have length 1; `None` if it is zero.
pub(crate) fn rotation_from_wxyz([w, x, y, z]: [f64; 4]) -> Option<Rotation> {
    Unit::try_new(Quaternion::new(w, x, y, z), LEAST_LENGTH)
}
