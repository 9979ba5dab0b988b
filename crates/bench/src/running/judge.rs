use std::fmt::Write as _;

use cranny_path::{Audit, AuditSettings, Cause, Clearances, PathError, Violation, audit_with, path_length};
use cranny_task::Problem;

use crate::{TrialOutcome, TrialRecord};

/// Writes the verdict on `path` into `record`, independently of the outcome reported by the planner: solved, rejected with
/// the first violation, or garbled if it is no path of this robot (`path` is then cleared). `path` has way points of one
/// value per joint (m, rad), unless it is garbled.
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

/// Returns true if a path of way points (m, rad; one value per joint) also meets the criterion of `problem`. If that criterion
/// checks way points alone, long edges are subdivided first, because other criteria do not limit their length.
///
/// # Errors
/// As [`audit_with`].
pub fn also_meets(problem: &Problem, path: &[Vec<f64>]) -> Result<bool, PathError> {
    let mut path = path.to_vec();
    /// Reduces edges of ten metres to a centimetre.
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
