use cranny_collision::{Cell, Motion};
use cranny_robot::JointLimits;
use cranny_task::{RoundedCorner, Segment, StateSequence};

use crate::clearance_limit::ClearanceLimit;
use crate::violation::{Cause, JointOffset};
use crate::{Audit, AuditSettings, Clearances, Violation};

/// Relative slack of the lower bound of the clearance of a rounded corner.
const SHARE: f64 = 0.02;

/// Audits the rounded corners of segments and merges the result into the audit of their edges, so that the verdict and the
/// clearances are valid for the edges and for the executed curve. Edges are numbered through all segments.
///
/// Every curve is proven from its control points in the state along its segment; the support of a held object is an obstacle.
/// The clearance of a curve, a certified lower bound, counts for both adjacent edges.
pub(crate) fn audit_corners(
    audit: &mut Audit,
    segments: &[Segment],
    along: &StateSequence,
    settings: AuditSettings,
) {
    let mut before = 0;
    for (segment, state) in segments.iter().zip(&along.states) {
        if !segment.corners.is_empty() {
            let judge = CornerJudge { cell: state.cell(), settings };
            for corner in &segment.corners {
                if audit.violations.len() >= settings.limits.violations {
                    break;
                }
                judge.judge(audit, corner, before + corner.waypoint);
            }
        }
        before += segment.waypoints.len().saturating_sub(1);
    }
    audit.valid = audit.violations.is_empty();
}

struct CornerJudge<'a> {
    cell: &'a Cell,
    settings: AuditSettings,
}

impl CornerJudge<'_> {
    /// Judges a corner between edge `edge` and the edge before it.
    fn judge(&self, audit: &mut Audit, corner: &RoundedCorner, edge: usize) {
        let (cell, points) = (self.cell, &corner.control_points);
        let (reach, scratch) = (cell.reach(), &mut cell.scratch());
        let fault = match cell.curve_is_free(points, &reach, scratch) {
            Motion::Contact { contact, .. } | Motion::Unresolved { contact, .. } => {
                Some(Violation::of_contact(cell, edge - 1, 1.0, &contact))
            }
            Motion::OutOfBounds { bound, by, .. } => {
                Some(Violation::out_of_bounds(cell, (edge - 1, 1.0), bound, by))
            }
            Motion::OutOfLimits { joint } => Some(beyond_limits(cell, points, joint, edge)),
            Motion::Proven => None,
        };
        let measured = match (&fault, self.settings.clearances) {
            (None, Clearances::None) => return,
            (None, _) => cell.curve_clearance(points, SHARE, scratch),
            (Some(_), _) => Ok((0.0, None)),
        };
        let (clearance_m, nearest, contradiction) = match measured {
            Ok((clearance_m, nearest)) => (clearance_m, nearest, None),
            Err(contact) => (0.0, None, Some(Violation::of_contact(cell, edge - 1, 1.0, &contact))),
        };
        audit.violations.extend(fault.or(contradiction));
        if !clearance_m.is_finite() {
            return;
        }
        let lower = |known: &mut Option<f64>| {
            *known = Some(known.map_or(clearance_m, |known| known.min(clearance_m)));
        };
        let of_edges = audit.clearance_m;
        lower(&mut audit.clearance_m);
        if audit.clearance_m != of_edges {
            audit.clearance_limit = nearest.map(|nearest| ClearanceLimit::of(cell, &nearest));
        }
        if self.settings.clearances == Clearances::OfEdges {
            for edge in [edge - 1, edge] {
                if let Some(known) = audit.clearances_per_edge_m.get_mut(edge) {
                    lower(known);
                }
            }
        }
    }
}

/// Returns the violation at way point `at` of a corner with control points (m, rad; one value per joint each) beyond a limit.
fn beyond_limits(cell: &Cell, control_points: &[Vec<f64>], joint: usize, at: usize) -> Violation {
    let robot = cell.robot();
    let JointLimits { lower, upper, unit, .. } = robot.limits()[joint];
    let excess = control_points.iter().map(|q| (lower - q[joint]).max(q[joint] - upper));
    let off = excess.fold(0.0, f64::max);
    let joint = robot.joint_names()[joint].clone();
    Violation::at_way_point(at, Cause::JointLimit(JointOffset { joint, off, unit }))
}
