use cranny_shape::{Solid, TriangleSoup};

use super::object_shape::ObjectShape;

/// Half the published diameter of 64.7 mm, in metres.
const RADIUS_M: f64 = 0.03235;

/// Subdivisions of the mesh: 5120 triangles, at most 0.03 mm inside the sphere.
const DIVISIONS: u32 = 4;

/// Subdivisions of the convex part: 1280 triangles, which lose less than one percent of the volume.
const PART_DIVISIONS: u32 = 3;

/// Returns a sphere.
pub fn shape() -> ObjectShape {
    let mesh = TriangleSoup::geodesic_sphere(RADIUS_M, DIVISIONS);
    let parts = vec![TriangleSoup::geodesic_sphere(RADIUS_M, PART_DIVISIONS)];
    ObjectShape { mesh, parts, solid: Solid::sphere(RADIUS_M).ok() }
}
