use cranny_robot::JointLimits;
use cranny_task::Problem;

use crate::{Cause, JointOffset, PathError, Violation};

/// Limits of an audit, which bound its time and memory for every path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AuditLimits {
    /// Maximum number of way points, those of all segments together.
    pub way_points: usize,
    /// Maximum travel of a path (m or rad): the sum over its edges of the travel of the joint that moves farthest.
    pub travel: u32,
    /// Number of violations at which the audit ends.
    pub violations: usize,
}

impl AuditLimits {
    /// Limits for paths from untrusted planners, of which one violation is reported. A path of ten metres sampled every
    /// millimetre has 10⁴ way points.
    pub const UNTRUSTED: Self = Self { way_points: 10_000, travel: 10_000, violations: 1 };
}

impl Default for AuditLimits {
    /// Limits that no real motion reaches: an hour sampled at 250 Hz has 9 · 10⁵ way points.
    fn default() -> Self {
        Self { way_points: 1_000_000, travel: 100_000, violations: 100_000 }
    }
}

/// Tolerance on the start of a path, per joint (m or rad). Way points are often written with six digits.
pub(crate) const START_TOLERANCE: f64 = 1e-5;

/// Excess over a joint limit (m or rad) up to which a path is still judged: a limit of another version of the robot, or a turn.
const MOST_EXCESS: f64 = 10.0;

/// Returns the violations of a path (m, rad; one value per joint) at its start and of the joint limits, and true if the audit
/// ends with them.
///
/// # Errors
/// As [`audit_with`](crate::audit_with).
pub(crate) fn first_violations(
    problem: &Problem,
    path: &[Vec<f64>],
    limits: AuditLimits,
) -> Result<(Vec<Violation>, bool), PathError> {
    check_count(path.len(), limits)?;
    for q in path {
        problem.check_configuration("way point", q)?;
    }
    let first = path.first().ok_or(PathError::EmptyPath)?;
    let at_start = first.iter().zip(problem.start()).enumerate().filter_map(|(joint, (a, b))| {
        let off = (a - b).abs();
        let cause = || Cause::Start(joint_offset(problem, joint, off));
        (off > START_TOLERANCE).then(|| Violation::at_way_point(0, cause()))
    });
    let mut violations: Vec<Violation> = at_start.collect();
    let of_start = violations.len();
    let joint_limits = problem.robot().limits();
    let beyond = |(way_point, q): (usize, &Vec<f64>)| {
        let beyond = |(joint, (value, limits)): (usize, (&f64, &JointLimits))| {
            let excess = (limits.lower - value).max(value - limits.upper);
            let cause = || Cause::JointLimit(joint_offset(problem, joint, excess));
            (excess > 0.0).then(|| Violation::at_way_point(way_point, cause()))
        };
        q.iter().zip(joint_limits).enumerate().filter_map(beyond).collect::<Vec<_>>()
    };
    let left = limits.violations.saturating_sub(of_start);
    violations.extend(path.iter().enumerate().flat_map(beyond).take(left));
    let is_far = |violation: &Violation| matches!(&violation.cause, Cause::JointLimit(offset) if offset.off > MOST_EXCESS);
    if violations.len() >= limits.violations || violations.iter().any(is_far) {
        return Ok((violations, true));
    }
    check_travel(path, limits)?;
    Ok((violations, false))
}

/// Returns the offset of a joint (m or rad) from a value, with its name and unit.
pub(crate) fn joint_offset(problem: &Problem, joint: usize, off: f64) -> JointOffset {
    let robot = problem.robot();
    JointOffset { joint: robot.joint_names()[joint].clone(), off, unit: robot.limits()[joint].unit }
}

pub(crate) fn check_count(actual: usize, limits: AuditLimits) -> Result<(), PathError> {
    let most = limits.way_points;
    if actual > most { Err(PathError::TooManyWayPoints { actual, most }) } else { Ok(()) }
}

/// Checks the travel of a path of finite numbers, whose differences may overflow.
fn check_travel(path: &[Vec<f64>], limits: AuditLimits) -> Result<(), PathError> {
    let mut travel = 0.0;
    for (edge, ends) in path.windows(2).enumerate() {
        let of_joints = ends[0].iter().zip(&ends[1]).map(|(a, b)| (b - a).abs());
        travel += of_joints.fold(0.0, f64::max);
        if travel > f64::from(limits.travel) {
            return Err(PathError::TooMuchTravel { edge, travel, most: limits.travel });
        }
    }
    Ok(())
}
