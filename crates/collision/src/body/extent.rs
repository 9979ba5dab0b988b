use std::sync::Arc;

use cranny_shape::{Outline, Solid, TriangleSoup, UnionMoments};
use cranny_spatial::{Point, Pose, Vector};

use crate::CollisionError;
use crate::body::world::Body;
use crate::touch::contact_patch::{Across, Seen};

/// Shape of a body of the world in the frame of its first solid: reach along any direction (support mapping), surface, and
/// centre of mass.
#[derive(Clone, Debug)]
pub struct Extent {
    parts: Arc<[ExtentPart]>,
    /// Outward normals of the largest faces, the largest first.
    normals: Arc<[Vector]>,
    /// Triangles of its convex hull.
    hull: Arc<[[Point; 3]]>,
    /// Centre of mass, as stated or at uniform density, and a bound on its error, in metres.
    center: Point,
    center_error_m: f64,
}

#[derive(Debug)]
struct ExtentPart {
    held_from_solid: Pose,
    /// The solid, if it is convex.
    convex: Option<Solid>,
    /// Corners of a mesh; empty for a convex solid.
    corners: Vec<Point>,
    triangles: Vec<[Point; 3]>,
    /// True if the tessellation lies within the solid, because the solid is round.
    is_round: bool,
}

/// Maximum number of largest faces of a body whose normals are stored.
const MOST_NORMALS: usize = 24;
/// Tolerance for coplanar facets of a hull, on normals (as a chord) and on heights (m): rounding.
const SAME_PLANE: f64 = 1e-9;
/// Maximum number of distinct normals before the largest faces are selected, by the area of the largest triangle of each.
const MOST_KNOWN: usize = 192;
/// Distance, as a chord, below which normals of faces count as equal.
pub(crate) const ONE_NORMAL: f64 = 1e-3;

impl Extent {
    /// Computes the extent of a body.
    ///
    /// # Errors
    /// [`CollisionError::Hold`] for an unbounded body.
    pub fn of(body: &Body) -> Result<Self, CollisionError> {
        let unusable = || CollisionError::Hold { name: body.name.clone() };
        let held_from_world = body.parts.first().ok_or_else(unusable)?.world_from_solid.inverse();
        let (mut parts, mut surface, mut flat) = (Vec::new(), TriangleSoup::default(), Vec::new());
        for part in &body.parts {
            let held_from_solid = held_from_world * part.world_from_solid;
            let is_convex = part.solid.support_point(&Vector::x()).is_some();
            let (points, _) = part.solid.bounding_points().ok_or_else(unusable)?;
            let mut own = TriangleSoup::default();
            own.append(&part.solid.tessellation().unwrap_or_default(), &held_from_solid);
            let triangles: Vec<[Point; 3]> =
                (0..own.triangles.len()).map(|index| own.corners(index)).collect();
            flat.extend(
                triangles
                    .iter()
                    .filter(|[a, b, c]| {
                        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector::zeros);
                        is_flat(&part.solid, &(held_from_solid.rotation.inverse() * normal))
                    })
                    .copied(),
            );
            parts.push(ExtentPart {
                held_from_solid,
                convex: is_convex.then(|| part.solid.clone()),
                corners: if is_convex {
                    Vec::new()
                } else {
                    points.iter().map(|p| held_from_solid * p).collect()
                },
                triangles,
                is_round: is_round(&part.solid),
            });
            surface.append(&own, &Pose::identity());
        }
        // A surface that encloses no volume has no centre of mass: take the centre of its bounding ball.
        let middle = || body.ball().map_or_else(Point::origin, |ball| held_from_world * ball.center);
        let (center, center_error_m) = match body.center_of_mass {
            Some(stated) => (stated, 0.0),
            None => UnionMoments::of_mesh(&surface)
                .map_or_else(|_| (middle(), 0.0), |of_union| (of_union.moments.center, of_union.error_m)),
        };
        let mut normals = greatest_normals(&flat, |_| true);
        normals.truncate(MOST_NORMALS);
        // A flat body has no hull.
        let hull = TriangleSoup::convex_hull(&surface.vertices).unwrap_or_default();
        let hull: Vec<_> = (0..hull.triangles.len()).map(|triangle| hull.corners(triangle)).collect();
        Ok(Self { parts: parts.into(), normals: normals.into(), hull: hull.into(), center, center_error_m })
    }

    /// Returns the centre of mass in the frame of the first solid, as stated or at uniform density; volume shared by solids counts once.
    pub fn center_of_mass(&self) -> Point {
        self.center
    }

    /// Returns the bound on the error of the centre of mass, in metres: 0 where its solids do not overlap.
    pub(crate) fn center_error_m(&self) -> f64 {
        self.center_error_m
    }

    /// Returns the least coordinate of the body along a direction (unit vector), in metres, with its first solid at a pose.
    pub fn lowest_along(&self, world_from_held: &Pose, direction: &Vector) -> f64 {
        let own = world_from_held.rotation.inverse() * direction;
        let lowest = self.parts.iter().map(|part| part.lowest_along(&own)).fold(f64::INFINITY, f64::min);
        lowest + direction.dot(&world_from_held.translation.vector)
    }

    /// Returns the surface triangles, with the first solid at a pose, that face against the direction and reach below a height
    /// (m) along it, projected along it. Those of a round solid are shifted down, so that they reach as low as the solid.
    pub(crate) fn lower_triangles(
        &self,
        world_from_held: &Pose,
        (across, direction): (&Across, &Vector),
        height_m: f64,
    ) -> Vec<Seen> {
        let own = world_from_held.rotation.inverse() * direction;
        let height_m = height_m - direction.dot(&world_from_held.translation.vector);
        let mut lower = Vec::new();
        for part in self.parts.iter() {
            let height = |corner: &Point| own.dot(&corner.coords);
            let raised_m = if part.is_round {
                let of_surface = part.triangles.iter().flatten().map(height);
                part.lowest_along(&own) - of_surface.fold(f64::INFINITY, f64::min)
            } else {
                0.0
            };
            for [a, b, c] in &part.triangles {
                let is_lower = [a, b, c].iter().any(|corner| height(corner) + raised_m <= height_m);
                if is_lower && (b - a).cross(&(c - a)).dot(&own) < 0.0 {
                    lower
                        .extend(across.triangle(&[a, b, c].map(|corner| world_from_held * corner), raised_m));
                }
            }
        }
        lower
    }

    /// Returns the planes of the faces of the body's convex hull, with the first solid at a pose, that reach below a height (m)
    /// along a direction and do not face that direction: the inward normal of each, and its height along that normal (m). The
    /// body can touch no other plane from above.
    pub(crate) fn lower_planes(
        &self,
        world_from_held: &Pose,
        direction: &Vector,
        height_m: f64,
    ) -> Vec<(Vector, f64)> {
        let own = world_from_held.rotation.inverse() * direction;
        let height_m = height_m - direction.dot(&world_from_held.translation.vector);
        let is_low = |corners: &&[Point; 3]| corners.iter().any(|corner| own.dot(&corner.coords) <= height_m);
        let mut planes: Vec<(Vector, f64)> = Vec::new();
        for [a, b, c] in self.hull.iter().filter(is_low) {
            let Some(outwards) = (b - a).cross(&(c - a)).try_normalize(0.0) else { continue };
            let normal = -(world_from_held.rotation * outwards);
            let height_m = normal.dot(&(world_from_held * a).coords);
            let is_known = |(other, other_m): &(Vector, f64)| {
                (other - normal).norm() < SAME_PLANE && (other_m - height_m).abs() < SAME_PLANE
            };
            if outwards.dot(&own) < 0.0 && !planes.iter().any(is_known) {
                planes.push((normal, height_m));
            }
        }
        planes
    }

    /// Returns the inward normals of the largest faces, the largest first, with the first solid at a pose.
    pub(crate) fn inward_normals(&self, world_from_held: &Pose) -> impl Iterator<Item = Vector> {
        self.normals.iter().map(|normal| -(world_from_held.rotation * normal))
    }
}

impl ExtentPart {
    /// Returns the least coordinate along a direction, both in the frame of the body, in metres.
    fn lowest_along(&self, own: &Vector) -> f64 {
        let of_corners = self.corners.iter().map(|corner| own.dot(&corner.coords));
        let of_convex = self.convex.iter().filter_map(|solid| {
            let farthest = solid.support_point(&(self.held_from_solid.rotation.inverse() * -own))?;
            Some(own.dot(&(self.held_from_solid * farthest).coords))
        });
        of_corners.chain(of_convex).fold(f64::INFINITY, f64::min)
    }
}

/// Returns true if the tessellation of a solid lies within it.
pub(crate) fn is_round(solid: &Solid) -> bool {
    matches!(solid.outline(), Outline::Segment { .. } | Outline::Cylinder { .. })
}

/// Returns true if a normal of the tessellation of a solid, in its frame, belongs to a flat face of the solid. Normals of round
/// surfaces only approximate a curve.
pub(crate) fn is_flat(solid: &Solid, normal: &Vector) -> bool {
    match solid.outline() {
        Outline::Segment { .. } => false,
        Outline::Cylinder { .. } => normal.z.abs() > 1.0 - ONE_NORMAL,
        _ => true,
    }
}

/// Returns the normals of the triangles that `is_asked` selects, merged if they are equal, in order of decreasing area.
pub(crate) fn greatest_normals<'a>(
    triangles: impl IntoIterator<Item = &'a [Point; 3]>,
    is_asked: impl Fn(&Vector) -> bool,
) -> Vec<Vector> {
    let areas = triangles.into_iter().map(|[a, b, c]| (b - a).cross(&(c - a)));
    let mut areas: Vec<(Vector, f64)> =
        areas.filter_map(|area| Some((area.try_normalize(0.0).filter(&is_asked)?, area.norm()))).collect();
    areas.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut known: Vec<(Vector, f64)> = Vec::new();
    for (normal, area) in areas {
        let room = MOST_KNOWN - known.len();
        match known.iter_mut().find(|(other, _)| (other - normal).norm() < ONE_NORMAL) {
            Some((_, sum)) => *sum += area,
            None if room > 0 => known.push((normal, area)),
            None => {}
        }
    }
    known.sort_by(|a, b| b.1.total_cmp(&a.1));
    known.into_iter().map(|(normal, _)| normal).collect()
}
