use cranny_task::{Problem, Segment, joined};

use crate::audit_limits::{check_count, first_violations};
use crate::{Audit, AuditSettings, PathError};

/// Returns the audit of segments whose verdict needs no proof, because a way point is more than 10 m or rad beyond a joint
/// limit, or because the start or the joint limits have as many violations as count; otherwise `None`.
///
/// # Errors
/// Those of [`audit_task`](crate::audit_task) that concern the way points.
pub fn audit_without_proof(
    problem: &Problem,
    segments: &[Segment],
    settings: AuditSettings,
) -> Result<Option<Audit>, PathError> {
    let count = segments.iter().map(|segment| segment.waypoints.len()).sum();
    check_count(count, settings.limits)?;
    let (violations, is_over) = first_violations(problem, &joined(segments), settings.limits)?;
    Ok(is_over.then(|| Audit::ended(problem, violations, settings)))
}
