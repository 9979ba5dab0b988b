use cranny_spatial::{Point, Pose, Vector};

use crate::span::Shape;

/// Distance by which a common point is inside both solids, in metres: a thousand times the rounding of a checker.
const DEPTH_M: f64 = 1e-9;

/// Maximum number of projections; they converge at once unless faces are nearly parallel.
const MOST_STEPS: usize = 60;

/// Returns a point of the solid `fixed` that is in the solid `moved`, at least `depth_m` (m) inside, wherever that one is moved by a
/// sum of up to ± each way; in the world, for solids with their poses there. `None` if none is found, and for hulls and meshes.
///
/// Alternating projections on both, the second one reduced by all ways (von Neumann 1950, ch. XIII).
pub(crate) fn common_point(
    (fixed, world_from_fixed): (&Shape, Pose),
    (moved, world_from_moved): (&Shape, Pose),
    ways: &[Vector],
    depth_m: f64,
) -> Option<Point> {
    let fixed = Reduced::new(fixed, world_from_fixed, &[], DEPTH_M)?;
    let moved = Reduced::new(moved, world_from_moved, ways, depth_m + DEPTH_M)?;
    let mut p = Point::from(world_from_moved.translation.vector);
    for _ in 0..MOST_STEPS {
        p = moved.nearest(&p);
        let next = fixed.nearest(&p);
        if (next - p).norm() < 0.1 * DEPTH_M {
            return Some(next);
        }
        p = next;
    }
    None
}

/// Returns true if a point is at least `depth_m` (m) inside of a solid, and some more; always false for hulls and meshes.
pub(crate) fn is_deep((solid, world_from_solid): (&Shape, Pose), p: &Point, depth_m: f64) -> bool {
    Reduced::new(solid, world_from_solid, &[], depth_m + DEPTH_M)
        .is_some_and(|reduced| (reduced.nearest(p) - p).norm() <= 0.1 * DEPTH_M)
}

/// Points that are some depth inside of a solid after a motion of a sum of up to ± each way: the sum of a box, given by two corners
/// in the frame of the solid, and a disc across z or a ball.
struct Reduced {
    world_from_solid: Pose,
    low: Vector,
    high: Vector,
    disc_m: f64,
    ball_m: f64,
}

impl Reduced {
    fn new(shape: &Shape, world_from_solid: Pose, ways: &[Vector], depth_m: f64) -> Option<Self> {
        let own = ways.iter().map(|way| world_from_solid.rotation.inverse_transform_vector(way));
        let by = own.fold(Vector::zeros(), |sum, way| sum + way.abs());
        let across_m = by.x.hypot(by.y);
        let of = |high: Vector, disc_m: f64, ball_m: f64| {
            let is_left = high.min() >= 0.0 && disc_m >= 0.0 && ball_m >= 0.0;
            is_left.then_some(Self { world_from_solid, low: -high, high, disc_m, ball_m })
        };
        match shape {
            Shape::Cuboid(half) => of(half - by.add_scalar(depth_m), 0.0, 0.0),
            Shape::Capsule { half_length_m, radius_m } => {
                // The ball gives what the segment is too short for.
                let along_m = by.z.min(*half_length_m);
                let ball_m = radius_m - across_m.hypot(by.z - along_m) - depth_m;
                of(Vector::new(0.0, 0.0, half_length_m - along_m), 0.0, ball_m)
            }
            Shape::Cylinder { half_length_m, radius_m } => {
                let half_length_m = half_length_m - by.z - depth_m;
                of(Vector::new(0.0, 0.0, half_length_m), radius_m - across_m - depth_m, 0.0)
            }
            Shape::HalfSpace => {
                let wide = Vector::repeat(f64::INFINITY);
                let high = Vector::new(wide.x, wide.y, -by.z - depth_m);
                Some(Self { world_from_solid, low: -wide, high, disc_m: 0.0, ball_m: 0.0 })
            }
            Shape::Hull { .. } | Shape::Mesh { .. } => None,
        }
    }

    fn nearest(&self, p: &Point) -> Point {
        let own = self.world_from_solid.inverse_transform_point(p).coords;
        let in_box = own.sup(&self.low).inf(&self.high);
        let beyond = own - in_box;
        let across = Vector::new(beyond.x, beyond.y, 0.0).cap_magnitude(self.disc_m);
        self.world_from_solid * Point::from(in_box + across + beyond.cap_magnitude(self.ball_m))
    }
}
