use cranny_collision::{Cell, ToolRegion};
use cranny_spatial::Vector;

use crate::word::word;

/// Bound on the pose of a link, as a certificate has it.
pub(crate) struct LinkBound {
    pub name: String,
    pub link: usize,
    pub region: ToolRegion,
}

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
}
