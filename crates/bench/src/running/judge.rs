use cranny_path::{
    Audit, AuditLimits, AuditSettings, Clearances, PathError, RELEASED_STEP_M, Stepper, audit_with,
    path_length,
};
use cranny_task::{Criterion, Problem};

use crate::asked::trial::short_detail;
use crate::{PlannerCall, TrialOutcome, TrialRecord};

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
            (record.outcome, record.detail) = (TrialOutcome::Garbled, Some(short_detail(&fault.to_string())));
            path.clear();
            return;
        }
    };
    if let Some(violation) = audit.violations.first() {
        (record.outcome, record.detail) =
            (TrialOutcome::Rejected, Some(short_detail(&violation.to_string())));
        return;
    }
    record.outcome = TrialOutcome::Solved;
    record.path_length = Some(path_length(path));
    record.clearance_m = audit.clearance_m;
    record.grasp = audit.goal.map(|goal| goal.grasp);
    record.grasp_score = audit.grasp_score(problem);
}

/// Returns the limits of the audit of a trial: only the first violation of a path is reported.
pub fn limits_for(call: &PlannerCall) -> AuditLimits {
    match call {
        PlannerCall::BuiltIn { .. } => AuditLimits { violations: 1, ..AuditLimits::default() },
        PlannerCall::Exec { .. } | PlannerCall::Released { .. } => AuditLimits::UNTRUSTED,
    }
}

/// Returns true if a path of way points (m, rad; one value per joint) also meets the criterion of `problem`. If that criterion
/// checks way points alone, long edges are subdivided first, because other criteria do not limit their length.
///
/// # Errors
/// As [`audit_with`]; also [`PathError::TooManyWayPoints`] for a path that has too many after its subdivision.
pub fn also_meets(problem: &Problem, path: &[Vec<f64>], limits: AuditLimits) -> Result<bool, PathError> {
    let settings = AuditSettings { clearances: Clearances::None, limits, ..AuditSettings::default() };
    let divided = match problem.criterion() {
        Criterion::Exact => None,
        Criterion::Paper => Some(in_steps(problem, path, limits.way_points)),
    };
    Ok(audit_with(problem, divided.as_deref().unwrap_or(path), settings)?.valid)
}

/// Halves the edges of a path that are longer than a step of the released planners, until it has more than `most` way points.
fn in_steps(problem: &Problem, path: &[Vec<f64>], most: usize) -> Vec<Vec<f64>> {
    /// Reduces edges of ten metres to a centimetre.
    const MOST_HALVINGS: u32 = 10;
    let robot = problem.robot();
    let mut stepper = Stepper::new(robot);
    // The next way points, the nearest one last, each with the number of halvings of the edge that ends there.
    let mut ahead: Vec<(Vec<f64>, u32)> = path.iter().rev().map(|q| (q.clone(), 0)).collect();
    let mut steps: Vec<Vec<f64>> = Vec::new();
    while let Some((next, halvings)) = ahead.pop() {
        let last = steps.last().filter(|last| {
            halvings < MOST_HALVINGS && stepper.displacement_between(robot, last, &next) > RELEASED_STEP_M
        });
        if let Some(last) = last {
            let middle = last.iter().zip(&next).map(|(a, b)| 0.5 * (a + b)).collect();
            ahead.extend([(next, halvings + 1), (middle, halvings + 1)]);
        } else {
            steps.push(next);
            if steps.len() > most {
                break;
            }
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use cranny_collision::Margins;
    use cranny_scenario::{OpenOptions, Scenario};

    use super::*;

    #[test]
    fn edges_are_divided_into_steps_in_linear_time_and_within_the_limit() {
        let options = OpenOptions { criterion: Some(Criterion::Paper), ..OpenOptions::default() };
        let scenario = Scenario::open("021", &options).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        let mut end = scenario.start.clone();
        end[0] += 0.35;
        let ends = [scenario.start.clone(), end];
        let divided = in_steps(&problem, &ends, 100);
        assert_eq!((divided.len(), &divided[0], &divided[4]), (5, &ends[0], &ends[1]));
        let mut stepper = Stepper::new(problem.robot());
        let mut is_step = |edge: &[Vec<f64>]| {
            stepper.displacement_between(problem.robot(), &edge[0], &edge[1]) <= RELEASED_STEP_M
        };
        assert!(divided.windows(2).all(&mut is_step));
        let back_and_forth: Vec<Vec<f64>> = (0..10_000).map(|index| ends[index % 2].clone()).collect();
        assert!(matches!(
            also_meets(&problem, &back_and_forth, AuditLimits::UNTRUSTED),
            Err(PathError::TooManyWayPoints { actual: 10_001, most: 10_000 })
        ));
    }
}
