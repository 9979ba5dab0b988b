use cranny_collision::{Cell, ToolRegion};
use cranny_spatial::Vector;

use crate::moment::Moved;
use crate::scene_text::word;

/// Bound on the pose of a link, as a certificate has it.
pub(crate) struct LinkBound {
    pub name: String,
    pub link: usize,
    pub region: ToolRegion,
}

/// Amount by which each bound is kept beyond the inequality of the checker, in metres or as a length of direction: a thousand
/// times the rounding of either.
const SLACK: f64 = 1e-11;

/// Maximum angle that a certificate states, in radians: a wider cone is narrowed to it.
const WIDEST_RAD: f64 = 3.1;

impl LinkBound {
    /// Returns the bounds of a cell, the tilt of the held object included.
    pub fn all(cell: &Cell) -> Vec<Self> {
        let robot = cell.robot();
        let of = |bound: &cranny_collision::ToolBound| Self {
            name: word(&bound.name),
            link: bound.link.as_deref().and_then(|name| robot.link_index(name)).unwrap_or(robot.tip()),
            region: match bound.region.clone() {
                ToolRegion::Cone { axis_in_link, toward, most_rad } => {
                    ToolRegion::Cone { axis_in_link, toward, most_rad: most_rad.min(WIDEST_RAD) }
                }
                other => other,
            },
        };
        cell.tool_bounds().map(of).collect()
    }

    /// Returns the bounded point in the frame of the link, in metres; its origin for a bound on a direction.
    pub fn point_in_link(&self) -> Vector {
        match &self.region {
            ToolRegion::Cone { .. } => Vector::zeros(),
            ToolRegion::Box { point_in_link, .. } | ToolRegion::Ball { point_in_link, .. } => {
                point_in_link.coords
            }
        }
    }

    /// Returns true if the motion of the bounded point satisfies the inequality of the checker.
    pub fn is_kept(&self, moved: &Moved) -> bool {
        [-0.5, 0.5].into_iter().all(|s| {
            let point = moved.center + moved.velocity * s;
            let bend_m = 0.125 * moved.acceleration + SLACK;
            match &self.region {
                ToolRegion::Cone { axis_in_link, toward, most_rad } => {
                    let axis = moved.pose.rotation * axis_in_link.normalize();
                    let off = axis + moved.turn.cross(&axis) * s - toward.normalize();
                    off.norm() + 0.125 * moved.swing + SLACK < 2.0 * libm::sin(0.5 * most_rad)
                }
                ToolRegion::Box { world_from_box, half_m, .. } => {
                    let in_box = world_from_box.inverse_transform_point(&point.into()).coords.abs();
                    (in_box - half_m).max() + bend_m < 0.0
                }
                ToolRegion::Ball { center, radius_m, .. } => {
                    (point - center.coords).norm() + bend_m < *radius_m
                }
            }
        })
    }
}
