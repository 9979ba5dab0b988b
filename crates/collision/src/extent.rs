use std::sync::Arc;

use cranny_shape::{Solid, TriangleSoup, VolumeMoments};
use cranny_spatial::{Point, Pose, Vector};

use crate::CollisionError;
use crate::world::Body;

/// Shape of a body of the world in the frame of its first solid: its reach along any direction (support mapping), its
/// surface, and its centre of mass.
#[derive(Clone, Debug)]
pub struct Extent {
    /// Its convex solids.
    solids: Vec<(Pose, Solid)>,
    /// The corners of its meshes.
    corners: Arc<[Point]>,
    /// Its surface.
    triangles: Arc<[[Point; 3]]>,
    /// Centre of mass at uniform density; where its solids overlap, the shared volume counts for each.
    center_of_mass: Point,
}

impl Extent {
    /// Extent of a body.
    ///
    /// # Errors
    /// [`CollisionError::Hold`] for one that has no end.
    pub fn of(body: &Body) -> Result<Self, CollisionError> {
        let unusable = || CollisionError::Hold { name: body.name.clone() };
        let held_from_world = body.parts.first().ok_or_else(unusable)?.world_from_solid.inverse();
        let (mut solids, mut corners, mut surface) = (Vec::new(), Vec::new(), TriangleSoup::default());
        for part in &body.parts {
            let held_from_part = held_from_world * part.world_from_solid;
            if part.solid.support_point(&Vector::x()).is_some() {
                solids.push((held_from_part, part.solid.clone()));
            } else {
                let (points, _) = part.solid.bounding_points().ok_or_else(unusable)?;
                corners.extend(points.iter().map(|point| held_from_part * point));
            }
            surface.append(&part.solid.tessellation().unwrap_or_default(), &held_from_part);
        }
        let triangles = (0..surface.triangles.len()).map(|triangle| surface.corners(triangle)).collect();
        // Of what encloses no volume, the middle.
        let middle = || body.ball().map_or_else(Point::origin, |ball| held_from_world * ball.center);
        let center_of_mass =
            VolumeMoments::of_mesh(&surface).map_or_else(|_| middle(), |moments| moments.center);
        Ok(Self { solids, corners: corners.into(), triangles, center_of_mass })
    }

    /// Least coordinate along a direction, a unit vector, of any point of the body with its first solid at a pose, in metres.
    pub fn lowest_along(&self, world_from_held: &Pose, direction: &Vector) -> f64 {
        let own = world_from_held.rotation.inverse() * direction;
        let of_corners = self.corners.iter().map(|corner| own.dot(&corner.coords));
        let of_solids = self.solids.iter().filter_map(|(held_from_solid, solid)| {
            let farthest = solid.support_point(&(held_from_solid.rotation.inverse() * -own))?;
            Some(own.dot(&(held_from_solid * farthest).coords))
        });
        let lowest = of_corners.chain(of_solids).fold(f64::INFINITY, f64::min);
        lowest + direction.dot(&world_from_held.translation.vector)
    }

    /// Triangles of the surface, with the first solid at a pose, that reach below a height (m) along a direction, and do not
    /// look that way.
    pub(crate) fn lower_triangles(
        &self,
        world_from_held: &Pose,
        direction: &Vector,
        height_m: f64,
    ) -> Vec<[Point; 3]> {
        let own = world_from_held.rotation.inverse() * direction;
        let height_m = height_m - direction.dot(&world_from_held.translation.vector);
        let is_lower = |[a, b, c]: &&[Point; 3]| {
            [a, b, c].iter().any(|corner| own.dot(&corner.coords) <= height_m)
                && (b - a).cross(&(c - a)).dot(&own) <= 0.0
        };
        let lower = self.triangles.iter().filter(is_lower);
        lower.map(|corners| corners.map(|corner| world_from_held * corner)).collect()
    }

    /// Centre of mass of uniform density, with the first solid at a pose.
    pub(crate) fn center_of_mass(&self, world_from_held: &Pose) -> Point {
        world_from_held * self.center_of_mass
    }
}
