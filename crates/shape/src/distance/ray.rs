use cranny_spatial::{Point, Vector};

use crate::Surface;

/// Intersection of a ray with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Distance along the ray, in metres.
    pub distance_m: f64,
    /// Index of the triangle.
    pub triangle: u32,
    /// Unit normal of the triangle, outwards by the right-hand rule: its product with the ray's direction is negative
    /// where the ray enters and positive where it leaves.
    pub normal: Vector,
}

impl Surface {
    /// All intersections with the ray from `origin` along the unit vector `direction` within `reach_m` (m), by distance,
    /// then by triangle. A ray through an edge meets each of its triangles; one that lies in a triangle's plane does not
    /// meet it. The origin itself counts.
    ///
    /// Tests a triangle by Möller & Trumbore 1997, "Fast, minimum storage ray/triangle intersection", whole.
    pub fn ray_hits(&self, origin: &Point, direction: &Vector, reach_m: f64) -> Vec<RayHit> {
        let mut hits = Vec::new();
        self.tree.along_ray(origin, direction, reach_m, |triangle| {
            let corners = &self.corners[triangle as usize];
            if let Some(distance_m) = distance_to_triangle(origin, direction, corners)
                && distance_m <= reach_m
            {
                let normal = triangle_normal(corners);
                hits.push(RayHit { distance_m, triangle, normal });
            }
        });
        hits.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m).then(a.triangle.cmp(&b.triangle)));
        hits
    }
}

/// Unit normal of a triangle, outwards by the right-hand rule; zero for a triangle without area.
pub(crate) fn triangle_normal(corners: &[Point; 3]) -> Vector {
    let [a, b, c] = corners;
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector::zeros)
}

fn distance_to_triangle(origin: &Point, direction: &Vector, corners: &[Point; 3]) -> Option<f64> {
    let [a, b, c] = corners;
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(&ac);
    let determinant = ab.dot(&across);
    if determinant == 0.0 {
        return None;
    }
    let from_a = origin - a;
    let u = from_a.dot(&across) / determinant;
    let along = from_a.cross(&ab);
    let v = direction.dot(&along) / determinant;
    let distance_m = ac.dot(&along) / determinant;
    let is_inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    (is_inside && distance_m >= 0.0).then_some(distance_m)
}
