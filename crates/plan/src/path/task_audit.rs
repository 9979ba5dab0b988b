use crate::{
    Audit, AuditSettings, Carrier, CarryEnd, Grip, Place, PlanError, Problem, Violation, audit_with,
};

/// The pieces of a task's path, each from where the one before ends, and what is said of them.
#[derive(Clone, Copy, Debug)]
pub struct TaskPath<'a> {
    /// To the grasp, the hand open and empty.
    pub reach: &'a [Vec<f64>],
    /// The object in the closed hand, off what it rested on.
    pub lift_off: &'a [Vec<f64>],
    /// And on from there.
    pub carry: &'a [Vec<f64>],
    /// What the hand is said to hold in each of the last two, and how far its fingers are apart, in metres.
    pub held: [Option<(&'a str, f64)>; 2],
    /// Where the object is to be carried; `None`: wherever the path ends.
    pub end: Option<&'a CarryEnd>,
}

/// A number that is said of how far the fingers are apart is right to within this, in metres.
const OPENING_TOLERANCE_M: f64 = 1e-4;
/// What the object may go farther than it may, in metres: straight lines in joint space are none in space.
const LENGTH_TOLERANCE_M: f64 = 1e-3;

/// Judges the path of a task, whoever made it: the way to the grasp as [`audit_with`] does, whether the hand closes there
/// on the object, every edge after that with the object in the hand, as it stands in it then, and where it ends. Edges are
/// counted through all pieces.
///
/// # Errors
/// As [`audit_with`].
pub fn audit_task(
    problem: &Problem,
    carrier: &Carrier,
    path: TaskPath<'_>,
    settings: AuditSettings,
) -> Result<Audit, PlanError> {
    let mut audit = audit_with(problem, path.reach, settings)?;
    let Some(grasp) = path.reach.last() else { return Err(PlanError::EmptyPath) };
    let way_point = path.reach.len() - 1;
    let grip = match carrier.close(grasp) {
        Ok(grip) => grip,
        Err(reason) => {
            audit.violations.push(Violation::Grip { way_point, reason });
            audit.valid = false;
            return Ok(audit);
        }
    };
    for (name, opening_m) in path.held.into_iter().flatten() {
        let off_m = (opening_m - grip.opening_m).abs();
        if name != carrier.object() || off_m.is_nan() || off_m > OPENING_TOLERANCE_M {
            let held = (carrier.object().to_owned(), grip.opening_m);
            audit.violations.push(Violation::Hold { way_point, said: (name.to_owned(), opening_m), held });
        }
    }
    lift_off(&mut audit, carrier, &grip, path, settings)?;
    carry(&mut audit, carrier, &grip, path, settings)?;
    audit.valid = audit.violations.is_empty();
    Ok(audit)
}

fn lift_off(
    audit: &mut Audit,
    carrier: &Carrier,
    grip: &Grip,
    path: TaskPath<'_>,
    settings: AuditSettings,
) -> Result<(), PlanError> {
    let (Some(grasp), Some(off)) = (path.reach.last(), path.lift_off.last()) else {
        return Err(PlanError::EmptyPath);
    };
    let before = path.reach.len() - 1;
    let lifting = grip.lifting(grasp, grasp)?;
    let anywhere = AuditSettings { at_goal: false, ..settings };
    append(audit, audit_with(&lifting, path.lift_off, anywhere)?, before);
    let mut scratch = lifting.exact_cell("audit")?.scratch();
    for (edge, ends) in path.lift_off.windows(2).enumerate() {
        if let Some((at, body)) = carrier.stays_off(grip, &ends[0], &ends[1], &mut scratch) {
            let (first, second) = (carrier.object().to_owned(), carrier.body_name(body));
            let place = Place { edge: before + edge, at, first, second };
            audit.violations.push(Violation::LiftOff { place });
        }
    }
    let way_point = before + path.lift_off.len() - 1;
    let (length_m, most_m) = (carrier.length_m(grip, path.lift_off), carrier.settings().most_m);
    if length_m > most_m + LENGTH_TOLERANCE_M {
        audit.violations.push(Violation::LongLiftOff { way_point, length_m, most_m });
    }
    if !carrier.is_off(grip, off, &mut grip.carrying_scratch()) {
        audit.violations.push(Violation::NotOff { way_point });
    }
    Ok(())
}

fn carry(
    audit: &mut Audit,
    carrier: &Carrier,
    grip: &Grip,
    path: TaskPath<'_>,
    settings: AuditSettings,
) -> Result<(), PlanError> {
    let (Some(off), Some(last)) = (path.lift_off.last(), path.carry.last()) else {
        return Err(PlanError::EmptyPath);
    };
    let before = path.reach.len() + path.lift_off.len() - 2;
    let ends = path.end.and_then(|end| carrier.ends(end)).filter(|_| settings.at_goal);
    let at_goal = ends.is_some();
    let carrying = grip.carrying(off, ends.unwrap_or_else(|| vec![off.clone()]))?;
    append(audit, audit_with(&carrying, path.carry, AuditSettings { at_goal, ..settings })?, before);
    if let Some(CarryEnd::Out { clear_m }) = path.end.filter(|_| settings.at_goal) {
        let clearance_m = grip.clearance_m(last, *clear_m, &mut grip.carrying_scratch());
        if clearance_m < *clear_m {
            let way_point = before + path.carry.len() - 1;
            audit.violations.push(Violation::NotOut { way_point, clearance_m, required_m: *clear_m });
        }
    }
    Ok(())
}

/// Adds what was found of a piece whose first edge has this number.
fn append(audit: &mut Audit, piece: Audit, before: usize) {
    audit.violations.extend(piece.violations.into_iter().map(|violation| violation.counted_from(before)));
    audit.clearances_per_edge_m.extend(piece.clearances_per_edge_m);
    audit.clearance_m = audit.clearance_m.into_iter().chain(piece.clearance_m).reduce(f64::min);
    let new = piece.not_checked.into_iter().filter(|pair| !audit.not_checked.contains(pair));
    let new: Vec<_> = new.collect();
    audit.not_checked.extend(new);
}
