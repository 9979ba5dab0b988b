use crate::{Audit, AuditSettings, Carrier, Place, PlanError, Problem, Violation, audit_with};

/// The pieces of a task's path, each from where the one before ends.
#[derive(Clone, Copy, Debug)]
pub struct TaskPath<'a> {
    /// To the grasp, the hand open and empty.
    pub reach: &'a [Vec<f64>],
    /// The object in the closed hand, off what it rested on.
    pub lift_off: &'a [Vec<f64>],
    /// And on from there.
    pub carry: &'a [Vec<f64>],
}

/// Judges the path of a task, whoever made it: the way to the grasp as [`audit_with`] does, whether the hand closes there
/// on the object, and every edge after that with the object in the hand, as it stands in it then. Edges are counted
/// through all pieces.
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
    let mut before = path.reach.len() - 1;
    let grip = match carrier.close(grasp) {
        Ok(grip) => grip,
        Err(reason) => {
            audit.violations.push(Violation::Grip { way_point: before, reason });
            audit.valid = false;
            return Ok(audit);
        }
    };
    let anywhere = AuditSettings { at_goal: false, ..settings };
    let lifting = grip.lifting(grasp, grasp)?;
    let lifted = audit_with(&lifting, path.lift_off, anywhere)?;
    append(&mut audit, lifted, before);
    let mut scratch = lifting.exact_cell("audit")?.scratch();
    for (edge, ends) in path.lift_off.windows(2).enumerate() {
        if let Some((at, body)) = carrier.stays_off(&grip, &ends[0], &ends[1], &mut scratch) {
            let (first, second) = (carrier.object().to_owned(), carrier.body_name(body));
            audit
                .violations
                .push(Violation::LiftOff { place: Place { edge: before + edge, at, first, second } });
        }
    }
    let Some(off) = path.lift_off.last() else { return Err(PlanError::EmptyPath) };
    before += path.lift_off.len() - 1;
    let carrying = grip.carrying(off, vec![off.clone()])?;
    let mut scratch = carrying.exact_cell("audit")?.scratch();
    if !carrier.is_off(&grip, off, &mut scratch) {
        audit.violations.push(Violation::NotOff { way_point: before });
    }
    append(&mut audit, audit_with(&carrying, path.carry, anywhere)?, before);
    audit.valid = audit.violations.is_empty();
    audit.clearance_m = audit.clearances_per_edge_m.iter().copied().flatten().reduce(f64::min);
    Ok(audit)
}

/// Adds what was found of a piece whose first edge has this number.
fn append(audit: &mut Audit, piece: Audit, before: usize) {
    audit.violations.extend(piece.violations.into_iter().map(|violation| violation.counted_from(before)));
    audit.clearances_per_edge_m.extend(piece.clearances_per_edge_m);
    let new = piece.not_checked.into_iter().filter(|pair| !audit.not_checked.contains(pair));
    let new: Vec<_> = new.collect();
    audit.not_checked.extend(new);
}
