use std::sync::Arc;

use cranny_spatial::{Point, Pose, Rotation, Vector, sin_cos};
use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::shape::SupportMap;

use crate::distance::convex::{Convex, Core, HullPoints};
use crate::error::usable;
use crate::hulls::quickhull::hull_faces;
use crate::inside::closed_mesh::check_closed;
use crate::solid::Kind;
use crate::{ShapeError, Solid, TriangleSoup, distance::parry, separation};

impl Solid {
    /// The convex hull of `points`; it contains every point. With more than [`MOST_HULL_CORNERS`] corners, it is the hull of
    /// 2000 of them, rounded by the protrusion of the others: some tenths of a millimetre for a sphere of 0.1 m.
    ///
    /// # Errors
    /// [`ShapeError::NotFinite`] or [`ShapeError::FlatHull`].
    pub fn hull(points: &[Point]) -> Result<Self, ShapeError> {
        for (vertex, p) in points.iter().enumerate() {
            usable(vertex, p)?;
        }
        let flat = ShapeError::FlatHull { points: points.len() };
        let given: Vec<_> = points.iter().map(parry::point).collect();
        let outer = outer_points(&given);
        if outer.len() > MOST_HULL_CORNERS {
            return rounded_hull(&outer, ROUNDED_CORNERS).ok_or(flat);
        }
        let Some((hull, faces)) = hull_faces(&outer) else { return Err(flat) };
        let volume: f64 = faces
            .iter()
            .map(|f| f.map(|v| hull[v as usize] - hull[0]))
            .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
            .sum();
        /// Volume of a cube of 10 µm; anything smaller is a plane with rounding errors.
        const LEAST_VOLUME_M3: f64 = 1e-15;
        if volume.is_nan() || volume.abs() < LEAST_VOLUME_M3 {
            return Err(flat);
        }
        // The library may merge nearly equal points. To contain all of them, the hull keeps every given point outside its
        // facets, and all points if the facets are not closed.
        let mut kept = hull.clone();
        let vertices = hull.iter().map(|p| parry::to_vector(*p).into()).collect();
        let is_closed = check_closed(&TriangleSoup { vertices, triangles: faces.clone() }).is_ok();
        let planes: Vec<(ParryVector, ParryVector)> = faces
            .iter()
            .map(|f| f.map(|v| hull[v as usize]))
            .map(|[a, b, c]| (a, (b - a).cross(c - a)))
            .filter(|(_, normal)| normal.length() > 0.0)
            .map(|(a, normal)| (a, normal.normalize()))
            .collect();
        let is_outside = |p: ParryVector| planes.iter().any(|(a, normal)| normal.dot(p - *a) > 1e-12);
        kept.extend(outer.iter().filter(|&&p| !is_closed || is_outside(p)));
        Ok(Self::convex(Convex::sharp(Core::Hull(Arc::new(HullPoints::new(&kept))))))
    }

    /// Volume swept by the solid in a straight motion along `shift` (m), as convex solids in its frame before the motion;
    /// empty for a half-space. Exact for cuboids, spheres and capsules, and for hulls of up to 150 corners. Otherwise
    /// never too small: a cylinder counts as the eight-sided prism around it, a larger hull as a rounded one of fewer
    /// corners (by 1 mm for a sphere of 0.1 m), the surface of a mesh as the hulls of its pieces. Points inside a mesh
    /// throughout the motion are not covered.
    #[must_use]
    pub fn swept(&self, shift: &Vector) -> Vec<Self> {
        /// Maximum number of corners of a swept hull; each query evaluates all of them.
        const MOST_CORNERS: u32 = 300;
        let over = |corners: &[Point], radius_m: f64| {
            let both_ends: Vec<_> =
                corners.iter().flat_map(|p| [parry::point(p), parry::point(&(p + shift))]).collect();
            if both_ends.len() > MOST_CORNERS as usize
                && let Some(Kind::Convex(hull)) =
                    rounded_hull(&both_ends, MOST_CORNERS).map(|hull| hull.kind().clone())
            {
                return Self::convex(Convex { core: hull.core.clone(), radius_m: hull.radius_m + radius_m });
            }
            Self::convex(Convex { core: Core::Hull(Arc::new(HullPoints::new(&both_ends))), radius_m })
        };
        match self.kind() {
            Kind::HalfSpace => Vec::new(),
            Kind::Convex(convex) => vec![over(&convex.bounding_points(), convex.radius_m)],
            Kind::Union(union) => union
                .pieces_near(self.aabb())
                .iter()
                .map(|piece| over(&piece.bounding_points(), piece.radius_m))
                .collect(),
            Kind::Mesh(mesh) => mesh.pieces().iter().map(|piece| over(piece, 0.0)).collect(),
        }
    }
}

/// Maximum number of corners that a hull keeps unchanged. Every distance query of a hull evaluates all its corners. The
/// search for them takes quadratic time: a second for this many.
pub const MOST_HULL_CORNERS: usize = 16_000;

/// Points without those clearly inside the hull of the farthest ones along many directions, in their order. Returns all
/// points if there are at most [`MOST_HULL_CORNERS`].
pub(crate) fn outer_points(points: &[ParryVector]) -> Vec<ParryVector> {
    /// Number of directions; each point is compared with the few hundred planes of their hull.
    const DIRECTIONS: u32 = 256;
    if points.len() <= MOST_HULL_CORNERS {
        return points.to_vec();
    }
    let Some((hull, faces)) = hull_faces(&farthest(points, DIRECTIONS)) else { return points.to_vec() };
    let plane = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|index| hull[index as usize]);
        let normal = (b - a).cross(c - a).try_normalize()?;
        Some((normal, normal.dot(a)))
    };
    let planes: Option<Vec<_>> = faces.iter().map(plane).collect();
    let Some(planes) = planes else { return points.to_vec() };
    /// Depth inside that exceeds any rounding, in metres.
    const CLEARLY_M: f64 = 1e-7;
    let is_inside = |p: &ParryVector| planes.iter().all(|(normal, at)| normal.dot(*p) < at - CLEARLY_M);
    points.iter().filter(|p| !is_inside(p)).copied().collect()
}

/// Points that are farthest along the axes and along `directions` directions, each once.
fn farthest(points: &[ParryVector], directions: u32) -> Vec<ParryVector> {
    let core = Core::Hull(Arc::new(HullPoints::new(points)));
    // Evenly spread over the sphere (Fibonacci lattice).
    let turn = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let direction = |index: u32| {
        let z = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(directions);
        let (sine, cosine) = sin_cos(turn * f64::from(index));
        let across = (1.0 - z * z).sqrt();
        ParryVector::new(across * cosine, across * sine, z)
    };
    let along_axes =
        [ParryVector::X, ParryVector::Y, ParryVector::Z].into_iter().flat_map(|axis| [axis, -axis]);
    let mut found: Vec<ParryVector> = along_axes
        .chain((0..directions).map(direction))
        .map(|direction| core.local_support_point(direction))
        .collect();
    found.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    found.dedup();
    found
}

/// Number of corners of a rounded hull; a sphere of 0.1 m is then rounded by 0.2 mm.
const ROUNDED_CORNERS: u32 = 2000;

/// Hull of about `corners` of the points, rounded so that it contains all; `None` if they span no volume.
pub(crate) fn rounded_hull(points: &[ParryVector], corners: u32) -> Option<Solid> {
    let chosen: Vec<Point> =
        farthest(points, corners).into_iter().map(|p| parry::to_vector(p).into()).collect();
    let inner = Solid::hull(&chosen).ok()?;
    let speck = Solid::convex(Convex::sharp(Core::Point));
    let stands_out_m = |p: &ParryVector| {
        let there = Pose::from_parts(Vector::new(p.x, p.y, p.z).into(), Rotation::identity());
        separation(&speck, &there, &inner, &Pose::identity(), f64::MAX).upper_m
    };
    let radius_m = points.iter().map(stands_out_m).fold(0.0, f64::max);
    let Kind::Convex(convex) = inner.kind() else { return None };
    radius_m
        .is_finite()
        .then(|| Solid::convex(Convex { core: convex.core.clone(), radius_m: radius_m + ROUNDING_M }))
}

/// Bound on the displacement of a corner by rounding, in metres.
const ROUNDING_M: f64 = 1e-9;
