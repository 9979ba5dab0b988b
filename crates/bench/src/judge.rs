use std::fmt::Write as _;

use cranny_plan::{AuditSettings, PlanError, Problem, Violation, audit_with, path_length};

use crate::TrialOutcome;
use crate::worker_message::TrialAnswer;

/// Puts the judge's word on the path of `answer`, whatever its planner says: solved, rejected with the first
/// objection, or garbled where it is no path of this robot.
pub fn judge(problem: &Problem, answer: TrialAnswer, settings: AuditSettings) -> TrialAnswer {
    let verification = match audit_with(problem, &answer.path, settings) {
        Ok(verification) => verification,
        Err(fault) => {
            let (outcome, detail) = (TrialOutcome::Garbled, Some(fault.to_string()));
            return TrialAnswer { outcome, detail, path: Vec::new(), ..answer };
        }
    };
    if let Some(violation) = verification.violations.first() {
        let others = verification.violations.len() - 1;
        let mut detail = violation.to_string();
        if others > 0 {
            let _ = write!(detail, " (and {others} more)");
        }
        return TrialAnswer { outcome: TrialOutcome::Rejected, detail: Some(detail), ..answer };
    }
    let grasp = verification.goal.map(|goal| goal.grasp);
    TrialAnswer {
        outcome: TrialOutcome::Solved,
        path_length: Some(path_length(&answer.path)),
        clearance_m: verification.clearance_m,
        grasp,
        grasp_score: verification.grasp_score(problem),
        ..answer
    }
}

/// Whether a path also meets the criterion of `problem`. Where that looks at way points alone, they are made as
/// dense as it wants them first: a planner under another criterion need not have known.
///
/// # Errors
/// As [`audit_with`].
pub fn also_meets(problem: &Problem, path: &[Vec<f64>]) -> Result<bool, PlanError> {
    let mut path = path.to_vec();
    /// Steps of ten metres become steps of a centimetre.
    const MOST_HALVINGS: usize = 10;
    for _ in 0..MOST_HALVINGS {
        let verification =
            audit_with(problem, &path, AuditSettings { clearances: false, ..AuditSettings::default() })?;
        let step = |violation: &Violation| match violation {
            Violation::Step { edge, .. } => Some(*edge),
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
