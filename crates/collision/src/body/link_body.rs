use cranny_robot::{LinkFrames, Robot};
use cranny_shape::{Bounds, Range, Solid, quick_lower_bound, reaches};
use cranny_spatial::{Point, Pose};

use crate::Part;

/// Solids of one link and their common bounds, in the link's frame.
#[derive(Clone, Debug)]
pub(crate) struct LinkBody {
    pub link: usize,
    pub shapes: Vec<(Pose, Solid)>,
    pub bounds: Bounds,
}

impl LinkBody {
    /// Returns all links of `robot` that have geometry.
    pub fn all(robot: &Robot) -> Vec<Self> {
        (0..robot.links().len()).filter_map(|link| Self::new(robot, link)).collect()
    }

    /// Creates the geometry of the link of this index; `None` if it has none.
    pub fn new(robot: &Robot, link: usize) -> Option<Self> {
        let shapes: Vec<(Pose, Solid)> = robot.links()[link]
            .collisions
            .iter()
            .map(|shape| (shape.link_from_shape, shape.solid.clone()))
            .collect();
        Self::of_shapes(link, shapes)
    }

    /// Creates the geometry of a link from solids, each at its `link_from_solid`; `None` if there are none or unbounded ones.
    pub fn of_shapes(link: usize, shapes: Vec<(Pose, Solid)>) -> Option<Self> {
        let mut points: Vec<(Point, f64)> = Vec::new();
        for (link_from_shape, solid) in &shapes {
            let (corners, radius_m) = solid.bounding_points()?;
            points.extend(corners.iter().map(|corner| (link_from_shape * corner, radius_m)));
        }
        (!points.is_empty()).then(|| Self { link, shapes, bounds: Bounds::around(&points) })
    }

    /// Returns the solids, each with its `world_from_solid`.
    pub fn placed<'a>(
        &'a self,
        frames: &LinkFrames,
    ) -> impl Iterator<Item = (Pose, &'a Solid)> + Clone + use<'a> {
        let world_from_link = *frames.link(self.link);
        self.shapes.iter().map(move |(pose, solid)| (world_from_link * pose, solid))
    }

    /// Returns an upper bound on the distance that any of its points moves from `before` to `after`, two poses of the link in
    /// one frame, in metres: the centre of the bounding ball is translated, and all other points rotate about it.
    pub fn moved_m(&self, before: &Pose, after: &Pose) -> f64 {
        let ball = &self.bounds.ball;
        let turn = before.rotation.inverse() * after.rotation;
        // Twice the sine of half the angle is the chord on the unit sphere.
        (after * ball.center - before * ball.center).norm() + 2.0 * turn.imag().norm() * ball.radius_m
    }

    /// Returns a lower bound of the distance (m) to a solid of the world, from balls and boxes; may be negative. Boxes are
    /// evaluated only if the bound from the balls does not exceed `enough_m` (m).
    pub fn quick_bound_to(&self, world_from_link: &Pose, part: &Part, enough_m: f64) -> f64 {
        let Part { world_from_solid, solid } = part;
        if solid.is_half_space() {
            let center = world_from_link * self.bounds.ball.center;
            return world_from_solid.inverse_transform_point(&center).z - self.bounds.ball.radius_m;
        }
        self.bounds.distance_bound(world_from_link, solid.bounds(), world_from_solid, enough_m)
    }
}

/// Computes lower and upper bounds of the distance of two groups of solids ([`cranny_shape::separation`]). Pairs that are
/// certainly farther apart than `beyond_m` (m) are not measured.
pub(crate) fn group_separation<'a>(
    first: impl Iterator<Item = (Pose, &'a Solid)>,
    second: &(impl Iterator<Item = (Pose, &'a Solid)> + Clone),
    beyond_m: f64,
) -> cranny_shape::Separation {
    group_separation_in(first, second, Range::to(beyond_m))
}

/// Computes these bounds within a range of interest ([`cranny_shape::separation_in`]).
pub(crate) fn group_separation_in<'a>(
    first: impl Iterator<Item = (Pose, &'a Solid)>,
    second: &(impl Iterator<Item = (Pose, &'a Solid)> + Clone),
    range: Range,
) -> cranny_shape::Separation {
    let mut best = cranny_shape::Separation { lower_m: range.beyond_m, upper_m: f64::INFINITY };
    for (pose_a, a) in first {
        for (pose_b, b) in second.clone() {
            let reach = range.reach_m(best.upper_m);
            if quick_lower_bound(a, &pose_a, b, &pose_b, reach) > reach {
                best.lower_m = best.lower_m.min(reach);
                continue;
            }
            let nearer = Range { beyond_m: reach, ..range };
            let found = cranny_shape::separation_in(a, &pose_a, b, &pose_b, nearer);
            best.lower_m = best.lower_m.min(found.lower_m);
            best.upper_m = best.upper_m.min(found.upper_m);
            if best.upper_m <= 0.0 {
                return best;
            }
        }
    }
    best
}

/// Returns true if the distance of two groups of solids is certified to reach `distance_m` (m), above 0.
pub(crate) fn group_reaches<'a>(
    first: impl Iterator<Item = (Pose, &'a Solid)>,
    second: &(impl Iterator<Item = (Pose, &'a Solid)> + Clone),
    distance_m: f64,
) -> bool {
    first.into_iter().all(|(pose_a, a)| {
        second.clone().all(|(pose_b, b)| {
            quick_lower_bound(a, &pose_a, b, &pose_b, distance_m) > distance_m
                || reaches(a, &pose_a, b, &pose_b, distance_m)
        })
    })
}
