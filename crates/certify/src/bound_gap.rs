use cranny_collision::ToolRegion;

use crate::link_bound::LinkBound;
use crate::moment::Moved;

/// Amount by which each bound is kept beyond the inequality of the checker, in metres or as a length of direction: a thousand
/// times the rounding of either.
const SLACK: f64 = 1e-11;

/// Returns true if the motion of the bounded point satisfies the inequality of the checker.
pub(crate) fn is_kept(bound: &LinkBound, moved: &Moved) -> bool {
    [-0.5, 0.5].into_iter().all(|s| {
        let point = moved.center + moved.velocity * s;
        let bend_m = 0.125 * moved.acceleration + SLACK;
        match &bound.region {
            ToolRegion::Cone { axis_in_link, toward, most_rad } => {
                let axis = moved.pose.rotation * axis_in_link.normalize();
                let off = axis + moved.turn.cross(&axis) * s - toward.normalize();
                off.norm() + 0.125 * moved.swing + SLACK < 2.0 * libm::sin(0.5 * most_rad)
            }
            ToolRegion::Box { world_from_box, half_m, .. } => {
                let in_box = world_from_box.inverse_transform_point(&point.into()).coords.abs();
                (in_box - half_m).max() + bend_m < 0.0
            }
            ToolRegion::Ball { center, radius_m, .. } => (point - center.coords).norm() + bend_m < *radius_m,
        }
    })
}
