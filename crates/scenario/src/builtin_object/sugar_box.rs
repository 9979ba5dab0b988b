use cranny_shape::Surface;
use cranny_spatial::Vector;

use super::Shape;

/// The published size, x to z, in metres.
const SIZE_M: [f64; 3] = [0.038, 0.089, 0.175];

/// A cuboid, upright along z.
pub fn shape() -> Shape {
    let mesh = Surface::cuboid_soup(&(Vector::from(SIZE_M) * 0.5));
    Shape { parts: vec![mesh.clone()], mesh }
}
