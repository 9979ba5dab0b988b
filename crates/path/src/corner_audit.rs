use cranny_collision::{Cell, Contact, Measuring, Motion, Scratch};
use cranny_task::Problem;

use crate::{Audit, AuditSettings, Clearances, CutCorner, Violation};

/// Judges the corners that a trajectory along a path cuts, and adds that to what was found of its edges: a verdict, and
/// clearances, that hold for the edges and for the curve that is executed. Under `paper` there is nothing to judge.
///
/// Every chord of a corner is proven to keep what is demanded and, besides, its distance from the curve. The clearance of a
/// corner, certified from below, counts for both edges between which it lies.
pub fn audit_cut_corners(
    problem: &Problem,
    corners: &[CutCorner],
    settings: AuditSettings,
    audit: &mut Audit,
) {
    let Some(cell) = problem.cell().filter(|_| !corners.is_empty()) else { return };
    let scratch = &mut cell.scratch();
    for corner in corners {
        let fault = corner.chords.windows(2).find_map(|chord| fault_of(cell, chord, corner, scratch));
        let clearance_m = match (&fault, settings.clearances) {
            (None, Clearances::None) => continue,
            (None, _) => clearance_m(cell, corner, scratch),
            (Some(_), _) => Ok(Some(0.0)),
        };
        let (clearance_m, contradiction) = match clearance_m {
            Ok(clearance_m) => (clearance_m, None),
            // The corner lies where its first edge ends.
            Err(contact) => (Some(0.0), Some(Violation::of_contact(cell, corner.edges[0], 1.0, &contact))),
        };
        audit.violations.extend(fault.or(contradiction));
        let lower = |known: &mut Option<f64>| {
            *known = known.iter().copied().chain(clearance_m).reduce(f64::min);
        };
        let of_edges = audit.clearance_m;
        lower(&mut audit.clearance_m);
        if audit.clearance_m != of_edges {
            // A pair that limits an edge is not what limits the corner.
            audit.clearance_limit = None;
        }
        if settings.clearances == Clearances::OfEdges {
            for edge in corner.edges {
                lower(&mut audit.clearances_per_edge_m[edge]);
            }
        }
    }
    audit.valid = audit.violations.is_empty();
}

/// Violation by a chord of a corner, if there is one.
fn fault_of(cell: &Cell, chord: &[Vec<f64>], corner: &CutCorner, scratch: &mut Scratch) -> Option<Violation> {
    match cell.motion_beyond(corner.deviation_m, &chord[0], &chord[1], scratch) {
        Motion::Contact { contact, .. } | Motion::Unresolved { contact, .. } => {
            Some(Violation::of_contact(cell, corner.edges[0], 1.0, &contact))
        }
        Motion::Proven | Motion::OutOfLimits { .. } => None,
    }
}

/// The least distance along a corner, in metres, certified from below; `None` where there is nothing to touch.
///
/// # Errors
/// A pair that was measured closer than it may be, whatever was proven.
fn clearance_m(cell: &Cell, corner: &CutCorner, scratch: &mut Scratch) -> Result<Option<f64>, Contact> {
    let (mut seen_m, mut least_m) = (f64::INFINITY, f64::INFINITY);
    for chord in corner.chords.windows(2) {
        let measuring = Measuring { below_m: seen_m, ..Measuring::default() };
        let measured = cell.measure_motion([&chord[0], &chord[1]], measuring, scratch);
        if let Some((_, contact)) = measured.contradiction {
            return Err(contact);
        }
        (seen_m, least_m) = (measured.seen_m, least_m.min(measured.least_m));
    }
    Ok(least_m.is_finite().then(|| (least_m - corner.deviation_m).max(0.0)))
}
