use cranny_spatial::{FARTHEST_M, Point, ROUNDING_M};

use crate::chain::frame_error::{FrameError, MovedBy};
use crate::{Robot, RobotError};

/// Unit roundoff of `f64`: half the distance between two numbers at 1.
const UNIT: f64 = 0.5 * f64::EPSILON;

impl Robot {
    /// Checks that the bounds used in proofs are valid for this robot: no point of it can be farther from the root than
    /// [`FARTHEST_M`], and rounding in double precision displaces no two of its links by more than [`ROUNDING_M`] together.
    /// `file` is the robot's source, for errors.
    ///
    /// # Errors
    /// [`RobotError::TooFar`] or [`RobotError::Unsteady`] for the first link that violates this.
    pub(crate) fn check_steadiness(&self, file: &str) -> Result<(), RobotError> {
        let mut errors = vec![FrameError::root(UNIT)];
        for (index, link) in self.links.iter().enumerate() {
            let mut here = errors[link.parent.unwrap_or(0)];
            let mut greatest = 0.0;
            if let Some(parent) = link.parent {
                let way_m = self.rest[parent].inv_mul(&self.rest[index]).translation.vector.norm();
                let own_joint = self.movers[index].get(self.movers[parent].len());
                let moved_by = own_joint.map(|mover| {
                    let limits = &self.limits[mover.joint];
                    greatest = limits.lower.abs().max(limits.upper.abs()) * mover.multiplier.abs();
                    // The midpoint of an interval is rounded; with a gear ratio, the product and the offset are rounded too.
                    let is_geared = (mover.multiplier - 1.0).abs() > 0.0;
                    let roundings = if is_geared { 3.0 } else { 1.0 };
                    MovedBy { kind: mover.kind, most: greatest, roundings, sine: UNIT }
                });
                here = here.beyond(way_m, moved_by);
                errors.push(here);
            }
            let reach = |shape: &crate::LinkShape| {
                let center: Point = shape.link_from_shape * shape.solid.ball().center;
                center.coords.norm() + shape.solid.ball().radius_m
            };
            let from_link_m = link.collisions.iter().map(reach).fold(0.0, f64::max);
            let farthest_m = here.farthest_m() + from_link_m;
            if farthest_m.is_nan() || farthest_m > FARTHEST_M {
                return Err(RobotError::TooFar {
                    file: file.to_owned(),
                    link: link.name.clone(),
                    farthest_m,
                });
            }
            let error_m = here.of_point_m(from_link_m);
            if error_m.is_nan() || error_m > 0.5 * ROUNDING_M {
                return Err(RobotError::Unsteady {
                    file: file.to_owned(),
                    link: link.name.clone(),
                    error_m,
                    greatest,
                });
            }
        }
        Ok(())
    }
}
