use cranny_shape::Solid;
use cranny_spatial::{Point, Pose, Rotation, Vector};

use crate::anatomy::{distance_m, extent_m};
use crate::hand::palm::LONGEST_FINGER_M;

/// Minimum distance between two sides that can hold an object, in metres.
const LEAST_OPENING_M: f64 = 1e-3;

/// Returns a frame with the given y, z as near as possible to the pointing direction of the fingers, and x along any hinges;
/// axes near those of the palm are snapped to them.
pub(crate) fn upright(y: &Vector, ahead: &Vector, hinge: Option<&Vector>) -> Option<Rotation> {
    let y = snapped(&y.try_normalize(1e-9)?, 5.0_f64.to_radians());
    let mut z = ahead - y * ahead.dot(&y);
    if let Some(hinge) = hinge {
        z -= hinge * z.dot(hinge);
    }
    let z = snapped(&z.try_normalize(1e-6)?, 25.0_f64.to_radians());
    let z = (z - y * z.dot(&y)).try_normalize(0.1)?;
    let axes = cranny_spatial::nalgebra::Matrix3::from_columns(&[y.cross(&z), y, z]);
    Some(Rotation::from_matrix(&axes))
}

/// Returns the axis of the frame within that angle of a direction, if there is one; else the direction.
fn snapped(direction: &Vector, within_rad: f64) -> Vector {
    let axes = [Vector::x(), Vector::y(), Vector::z()].into_iter().flat_map(|axis| [axis, -axis]);
    let near = |axis: &Vector| axis.dot(direction) > cranny_spatial::sin_cos(within_rad).1;
    axes.into_iter().find(near).unwrap_or(*direction)
}

/// Geometry of the grip.
pub(crate) struct Place {
    pub origin: Point,
    pub opening_m: f64,
    pub finger_depth_m: f64,
}

/// Distance of the gripper frame behind the tips of fingers of that length, in metres.
pub(crate) fn inset_m(finger_m: f64) -> f64 {
    (0.15 * finger_m).clamp(0.003, 0.012)
}

/// Returns the grip centred between two sides, slightly behind the end of the shorter one; `all` is the whole hand. `None` for
/// a side without geometry.
pub(crate) fn place(
    rotation: &Rotation,
    [low, high]: &[Vec<(Pose, Solid)>; 2],
    all: &[(Pose, Solid)],
    hinge_z: f64,
    between: &Point,
) -> Option<Place> {
    if low.is_empty() || high.is_empty() {
        return None;
    }
    let axis = |unit: Vector| rotation * unit;
    let (x, y, z) = (axis(Vector::x()), axis(Vector::y()), axis(Vector::z()));
    let tip_z = extent_m(low, &z).min(extent_m(high, &z));
    let depth_z = tip_z - inset_m(tip_z - hinge_z);
    let both: Vec<(Pose, Solid)> = low.iter().chain(high).cloned().collect();
    let middle_x = 0.5 * (extent_m(&both, &x) - extent_m(&both, &-x));
    let at = |across: f64| Point::from(x * middle_x + y * across + z * depth_z);
    // The origin is equidistant from both sides.
    let (mut near, mut far) = (-extent_m(low, &-y), extent_m(high, &y));
    for _ in 0..60 {
        let across = 0.5 * (near + far);
        let point = at(across);
        if distance_m(low, &point) < distance_m(high, &point) { near = across } else { far = across }
    }
    let mut origin = at(0.5 * (near + far));
    // The bisection has an error of up to half a tenth of a millimetre.
    if (origin - between).dot(&y).abs() < 1e-4 {
        origin += y * (between - origin).dot(&y);
    }
    let opening_m = distance_m(low, &origin) + distance_m(high, &origin);
    let finger_depth_m = free_way_m(all, &origin, &-z);
    (opening_m > LEAST_OPENING_M).then_some(Place { origin, opening_m, finger_depth_m })
}

/// Returns the free distance from a point in a direction to a solid, in metres; at most the maximum length of a finger.
pub(crate) fn free_way_m(solids: &[(Pose, Solid)], from: &Point, direction: &Vector) -> f64 {
    /// Distance that counts as contact, in metres.
    const THERE_M: f64 = 1e-4;
    let mut way_m = 0.0;
    while way_m < LONGEST_FINGER_M {
        let gap_m = distance_m(solids, &(from + direction * way_m));
        if gap_m < THERE_M {
            break;
        }
        way_m += gap_m;
    }
    way_m.clamp(THERE_M, LONGEST_FINGER_M)
}
