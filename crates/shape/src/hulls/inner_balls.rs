use cranny_spatial::Point;

use crate::distance::convex::Core;
use crate::inside::closed_mesh::check_closed;
use crate::solid::Kind;
use crate::{Ball, Solid, TriangleSoup};

/// At most `count` balls inside a convex solid that fill much of it, the largest first, in the solid's frame. Empty for a mesh
/// or a half-space.
///
/// The candidates are the largest inner balls around the points of a grid in the solid's box. Always takes the candidate that
/// protrudes farthest from those taken before.
pub fn inner_balls(solid: &Solid, count: usize) -> Vec<Ball> {
    let Some(depth) = depth_below_surface(solid) else { return Vec::new() };
    let candidates: Vec<Ball> = grid(solid)
        .map(|center| Ball { center, radius_m: depth(&center) })
        .filter(|ball| ball.radius_m > 0.0)
        .collect();
    /// Minimum gain of a further ball, in metres; smaller gains are not worth the time of the ball.
    const LEAST_GAIN_M: f64 = 2e-3;
    let mut gains: Vec<f64> = candidates.iter().map(|ball| ball.radius_m).collect();
    let mut chosen: Vec<Ball> = Vec::new();
    while chosen.len() < count {
        let best = (0..candidates.len()).max_by(|&a, &b| gains[a].total_cmp(&gains[b]));
        let Some(best) = best.filter(|&best| chosen.is_empty() || gains[best] > LEAST_GAIN_M) else { break };
        let ball = candidates[best];
        chosen.push(ball);
        for (gain, candidate) in gains.iter_mut().zip(&candidates) {
            let beyond = (candidate.center - ball.center).norm() - ball.radius_m + candidate.radius_m;
            *gain = gain.min(beyond);
        }
    }
    chosen.sort_by(|a, b| b.radius_m.total_cmp(&a.radius_m));
    chosen
}

/// Lower bound of the depth of a point below a surface, in metres; negative outside.
type Depth<'a> = Box<dyn Fn(&Point) -> f64 + 'a>;

/// Depth below the surface of the solid; `None` if it is not convex.
fn depth_below_surface(solid: &Solid) -> Option<Depth<'_>> {
    let Kind::Convex(convex) = solid.kind() else { return None };
    let radius_m = convex.radius_m;
    Some(match &convex.core {
        Core::Point => Box::new(move |p| radius_m - p.coords.norm()),
        Core::Segment { half_length } => Box::new(move |p| {
            let along = p.z.clamp(-half_length, *half_length);
            radius_m - (p - Point::new(0.0, 0.0, along)).norm()
        }),
        Core::Cuboid { half_extents } => Box::new(move |p| (half_extents - p.coords.abs()).min()),
        Core::Cylinder { half_length, radius } => {
            Box::new(move |p| (half_length - p.z.abs()).min(radius - (p.x * p.x + p.y * p.y).sqrt()))
        }
        Core::Hull(hull) => {
            // A point below all faces lies in the hull only if the faces are closed. A hull algorithm may fail to close them
            // where a hull is thin.
            let faces = TriangleSoup::convex_hull(&hull.iter().collect::<Vec<_>>()).ok()?;
            check_closed(&faces).ok()?;
            let planes = faces.planes();
            Box::new(move |p| planes.iter().map(|plane| -plane.height(p)).fold(f64::MAX, f64::min))
        }
        Core::Triangle(_) => return None,
    })
}

/// Points of a grid in the box of the solid, including its centre.
fn grid(solid: &Solid) -> impl Iterator<Item = Point> {
    /// Number of points along each side; odd, so that one is in the middle.
    const SIDE: i32 = 13;
    let aabb = *solid.aabb();
    let place = |index: i32| f64::from(2 * (index + 1) - SIDE - 1) / f64::from(SIDE + 1);
    (0..SIDE * SIDE * SIDE).map(move |index| {
        let at = cranny_spatial::Vector::new(
            place(index % SIDE),
            place(index / SIDE % SIDE),
            place(index / SIDE / SIDE),
        );
        aabb.center + aabb.half_extents.component_mul(&at)
    })
}
