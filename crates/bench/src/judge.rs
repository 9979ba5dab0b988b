use std::fmt::Write as _;

use cranny_plan::{
    ClearanceReport, Goal, PlanError, Problem, Violation, ViolationKind, path_length, verify_with,
};

use crate::TrialOutcome;
use crate::worker_message::TrialAnswer;

/// Puts the judge's word on the path of `answer`, whatever its planner says: solved, rejected with the first
/// objection, or garbled where it is no path of this robot.
pub fn judge(problem: &Problem, answer: TrialAnswer, report: ClearanceReport) -> TrialAnswer {
    let verification = match verify_with(problem, &answer.path, report) {
        Ok(verification) => verification,
        Err(fault) => {
            let (outcome, detail) = (TrialOutcome::Garbled, Some(fault.to_string()));
            return TrialAnswer { outcome, detail, path: Vec::new(), ..answer };
        }
    };
    if let Some(violation) = verification.violations.first() {
        let others = verification.violations.len() - 1;
        let mut detail = objection(violation);
        if others > 0 {
            let _ = write!(detail, " (and {others} more)");
        }
        return TrialAnswer { outcome: TrialOutcome::Rejected, detail: Some(detail), ..answer };
    }
    let grasp = verification.goal.map(|goal| goal.grasp);
    let score = match &problem.goal {
        Goal::Grasps(grasps) => grasp.and_then(|grasp| grasps.grasps()[grasp].score),
        Goal::Configurations(_) => None,
    };
    TrialAnswer {
        outcome: TrialOutcome::Solved,
        path_length: Some(path_length(&answer.path)),
        clearance_m: verification.clearance_m,
        grasp,
        grasp_score: score,
        ..answer
    }
}

/// Whether a path also meets the criterion of `problem`. Where that looks at way points alone, they are made as
/// dense as it wants them first: a planner under another criterion need not have known.
///
/// # Errors
/// As [`verify_with`].
pub fn also_meets(problem: &Problem, path: &[Vec<f64>]) -> Result<bool, PlanError> {
    let mut path = path.to_vec();
    /// Steps of ten metres become steps of a centimetre.
    const MOST_HALVINGS: usize = 10;
    for _ in 0..MOST_HALVINGS {
        let verification = verify_with(problem, &path, ClearanceReport::Left)?;
        let is_step = |violation: &&Violation| violation.kind == ViolationKind::Step;
        let steps: Vec<usize> = verification.violations.iter().filter(is_step).map(|v| v.edge).collect();
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

/// A violation in a sentence.
fn objection(violation: &Violation) -> String {
    let Violation { kind, edge, at, first, second, depth_m } = violation;
    match kind {
        ViolationKind::Contact if second.is_empty() => format!("way point {edge} is not free"),
        ViolationKind::Contact => {
            format!("edge {edge} at {at:.3}: {first} is {:.2} mm deep in {second}", depth_m * 1e3)
        }
        ViolationKind::Clearance => format!("edge {edge} at {at:.3}: {first} comes too close to {second}"),
        ViolationKind::Unresolved => {
            format!("edge {edge} at {at:.3}: {first} against {second} can be neither proven nor refuted")
        }
        ViolationKind::JointLimit => format!("way point {edge}: {first} is {depth_m:.4} beyond its limit"),
        ViolationKind::Step => format!("edge {edge} is longer than the released planners step"),
        ViolationKind::Start => format!("{first} is {depth_m:.6} off the start"),
        ViolationKind::Goal => format!("the path ends {:.2} mm from the nearest goal", depth_m * 1e3),
        _ => format!("edge {edge} is not valid"),
    }
}
