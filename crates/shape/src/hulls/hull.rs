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
    /// The convex hull of `points`. Of more than [`MOST_HULL_CORNERS`] corners, it is the hull of 2000 of them,
    /// rounded by as much as the others stand out of it: some tenths of a millimetre for a sphere of 0.1 m.
    /// In either case it contains every point.
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
        /// A cube of 10 µm: what is smaller is a plane with rounding errors.
        const LEAST_VOLUME_M3: f64 = 1e-15;
        if volume.is_nan() || volume.abs() < LEAST_VOLUME_M3 {
            return Err(flat);
        }
        // The library may merge nearly equal points; to contain all of them the hull keeps every given
        // point that its facets leave outside, and all points where the facets do not close it in.
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

    /// What the solid sweeps over while it moves straight along `shift` (m), in its frame before the motion, as convex
    /// solids; nothing for a half-space. Exact for cuboids, spheres and capsules, and for hulls of up to 150 corners;
    /// else never too small: a cylinder counts as the prism of eight sides around it, a hull of more corners as one of
    /// fewer, rounded (by 1 mm for a sphere of 0.1 m), the surface of a mesh as the hulls of its pieces. What stays inside
    /// a mesh all the way is not swept over.
    #[must_use]
    pub fn swept(&self, shift: &Vector) -> Vec<Self> {
        /// Every question to a hull asks all its corners.
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
            Kind::Mesh(mesh) => mesh.pieces().iter().map(|piece| over(piece, 0.0)).collect(),
        }
    }
}

/// A hull keeps up to so many corners as they are. Every distance to a hull runs through all its corners, and the
/// search for them takes time by the square of their number: a second for these.
pub const MOST_HULL_CORNERS: usize = 16_000;

/// The points without those that lie clearly inside the hull of the farthest ones along many directions, if there
/// are more than [`MOST_HULL_CORNERS`]; in their order.
pub(crate) fn outer_points(points: &[ParryVector]) -> Vec<ParryVector> {
    /// A share of some hundred planes is all that a point inside is compared with.
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
    /// Deeper inside than any rounding, in metres.
    const CLEARLY_M: f64 = 1e-7;
    let is_inside = |p: &ParryVector| planes.iter().all(|(normal, at)| normal.dot(*p) < at - CLEARLY_M);
    points.iter().filter(|p| !is_inside(p)).copied().collect()
}

/// The points that are farthest along as many directions, each once.
fn farthest(points: &[ParryVector], directions: u32) -> Vec<ParryVector> {
    let core = Core::Hull(Arc::new(HullPoints::new(points)));
    // Evenly over the sphere (Fibonacci's lattice).
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

/// A sphere of 0.1 m is then rounded by 0.2 mm.
const ROUNDED_CORNERS: u32 = 2000;

/// The hull of about so many of the points, rounded so far that it contains all; `None` if they span no volume.
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

/// More than rounding moves a corner by, in metres.
const ROUNDING_M: f64 = 1e-9;
