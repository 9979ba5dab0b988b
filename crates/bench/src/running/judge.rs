use std::fmt::Write as _;

use cranny_path::{Audit, AuditSettings, Cause, Clearances, PathError, Violation, audit_with, path_length};
use cranny_task::Problem;

use crate::{TrialOutcome, TrialRecord};

/// Writes into `record` what the judge's word makes of `path`, whatever its planner says: solved, rejected with the
/// first objection, or garbled, and then no path, where it is none of this robot. `path` has way points of one value
/// per joint (m, rad), unless it is garbled.
pub fn decide(
    record: &mut TrialRecord,
    path: &mut Vec<Vec<f64>>,
    problem: &Problem,
    word: Result<Audit, PathError>,
) {
    let audit = match word {
        Ok(audit) => audit,
        Err(fault) => {
            (record.outcome, record.detail) = (TrialOutcome::Garbled, Some(fault.to_string()));
            path.clear();
            return;
        }
    };
    if let Some(violation) = audit.violations.first() {
        let others = audit.violations.len() - 1;
        let mut detail = violation.to_string();
        if others > 0 {
            let _ = write!(detail, " (and {others} more)");
        }
        (record.outcome, record.detail) = (TrialOutcome::Rejected, Some(detail));
        return;
    }
    record.outcome = TrialOutcome::Solved;
    record.path_length = Some(path_length(path));
    record.clearance_m = audit.clearance_m;
    record.grasp = audit.goal.map(|goal| goal.grasp);
    record.grasp_score = audit.grasp_score(problem);
}

/// Whether a path of way points (m, rad; one value per joint) also meets the criterion of `problem`. Where that looks
/// at way points alone, they are made as dense as it wants them first: a planner under another criterion need not
/// have known.
///
/// # Errors
/// As [`audit_with`].
pub fn also_meets(problem: &Problem, path: &[Vec<f64>]) -> Result<bool, PathError> {
    let mut path = path.to_vec();
    /// Steps of ten metres become steps of a centimetre.
    const MOST_HALVINGS: usize = 10;
    for _ in 0..MOST_HALVINGS {
        let verification = audit_with(
            problem,
            &path,
            AuditSettings { clearances: Clearances::None, ..AuditSettings::default() },
        )?;
        let step = |violation: &Violation| match violation.cause {
            Cause::Step { .. } => Some(violation.at.edge),
            _ => None,
        };
        let steps: Vec<usize> = verification.violations.iter().filter_map(step).collect();
        if steps.is_empty() {
            return Ok(verification.valid);
        }
        for edge in steps.into_iter().rev() {
            let middle = path[edge].iter().zip(&path[edge + 1]).map(|(a, b)| 0.5 * (a + b)).collect();
            path.insert(edge + 1, middle);
        }
    }
    Ok(false)
}
