use cranny_spatial::{Point, Vector};

use crate::error::usable;
use crate::hulls::hull::outer_points;
use crate::hulls::quickhull::hull_faces;
use crate::{ShapeError, TriangleSoup, distance::parry};

/// Plane whose unit normal points out of a hull.
pub(crate) struct Plane {
    normal: Vector,
    offset: f64,
}

impl Plane {
    /// Height of a point above the plane, in metres; negative below.
    pub fn height(&self, point: &Point) -> f64 {
        self.normal.dot(&point.coords) - self.offset
    }

    pub fn normal(&self) -> &Vector {
        &self.normal
    }
}

impl TriangleSoup {
    /// Planes of the faces, except those without area.
    pub(crate) fn planes(&self) -> Vec<Plane> {
        let plane = |face: usize| {
            let [a, b, c] = self.corners(face);
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
            Some(Plane { offset: normal.dot(&a.coords), normal })
        };
        (0..self.triangles.len()).filter_map(plane).collect()
    }

    /// The convex hull of `points` as a closed mesh, normals outwards.
    ///
    /// # Errors
    /// [`ShapeError::NotFinite`], or [`ShapeError::FlatHull`] for points in one plane.
    pub fn convex_hull(points: &[Point]) -> Result<Self, ShapeError> {
        for (vertex, p) in points.iter().enumerate() {
            usable(vertex, p)?;
        }
        let given: Vec<_> = points.iter().map(parry::point).collect();
        let flat = || ShapeError::FlatHull { points: points.len() };
        let (vertices, triangles) = hull_faces(&outer_points(&given)).ok_or_else(flat)?;
        let vertices = vertices.into_iter().map(|v| parry::to_vector(v).into()).collect();
        let hull = Self { vertices, triangles };
        if hull.signed_volume_m3() > 0.0 { Ok(hull) } else { Err(flat()) }
    }

    /// Volume that the triangles enclose, in cubic metres: negative for normals inwards, meaningless for a mesh with a hole.
    pub fn signed_volume_m3(&self) -> f64 {
        let Some(eye) = self.vertices.first() else { return 0.0 };
        let of_tetrahedron = |index: usize| {
            let [a, b, c] = self.corners(index).map(|corner| corner - eye);
            a.dot(&b.cross(&c)) / 6.0
        };
        (0..self.triangles.len()).map(of_tetrahedron).sum()
    }
}
