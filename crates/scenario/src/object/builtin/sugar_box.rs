use cranny_shape::{Solid, Surface};
use cranny_spatial::Vector;

use super::object_shape::ObjectShape;

/// Published size, x to z, in metres.
const SIZE_M: [f64; 3] = [0.038, 0.089, 0.175];

/// Returns a cuboid, upright along z.
pub fn shape() -> ObjectShape {
    let half = Vector::from(SIZE_M) * 0.5;
    let mesh = Surface::cuboid_soup(&half);
    ObjectShape { parts: vec![mesh.clone()], mesh, solid: Solid::cuboid(half).ok() }
}
