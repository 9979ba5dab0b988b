use cranny_shape::{Solid, TriangleSoup};

use super::object_shape::ObjectShape;

/// Half the published diameter of 64.7 mm.
const RADIUS_M: f64 = 0.03235;

/// 5120 triangles, nowhere more than 0.03 mm inside the sphere.
const DIVISIONS: u32 = 4;

/// 1280 triangles: less than one percent of the volume is missing.
const PART_DIVISIONS: u32 = 3;

/// A sphere.
pub fn shape() -> ObjectShape {
    let mesh = TriangleSoup::geodesic_sphere(RADIUS_M, DIVISIONS);
    let parts = vec![TriangleSoup::geodesic_sphere(RADIUS_M, PART_DIVISIONS)];
    ObjectShape { mesh, parts, solid: Solid::sphere(RADIUS_M).ok() }
}
